"""Draw the rooms of the library and which of them import which, from the imports themselves.

    python docs/draw_rooms.py            writes docs/rooms.svg
    python docs/draw_rooms.py --check    exits with 1 when the picture is out of date

A room is a package or module directly below `wbc`. Bands are the layers of the contract in
pyproject.toml, which CI enforces; a dot says that the room of the row imports that of the column.
All dots lie right of the diagonal: no room imports from one above it.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from html import escape
from pathlib import Path

import grimp

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "rooms.svg"
NAME, TEXT, CELL, HEAD = 130, 620, 24, 110  # widths and heights in pixels


def layers() -> list[list[str]]:
    """Rooms by layer, the top first."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    (layered,) = (c for c in contracts if c["type"] == "layers" and c["containers"] == ["wbc"])
    return [re.split(r"\s*[:|]\s*", layer) for layer in layered["layers"]]


def imports(rooms: list[str]) -> dict[str, set[str]]:
    """For each room, the rooms that its files import."""
    graph = grimp.build_graph("wbc", exclude_type_checking_imports=True)
    found: dict[str, set[str]] = {room: set() for room in rooms}
    for module in graph.modules:
        importer = module.split(".")[1] if "." in module else ""
        for imported in graph.find_modules_directly_imported_by(module):
            room = imported.split(".")[1] if "." in imported else ""
            if importer in found and room in found and room != importer:
                found[importer].add(room)
    return found


def summary(room: str) -> str:
    """The first sentence of a room's docstring, up to its colon."""
    path = ROOT / "wbc" / room / "__init__.py"
    path = path if path.exists() else ROOT / "wbc" / f"{room}.py"
    text = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").splitlines()
    return text[0].rstrip(".") if text else ""


def drawing() -> str:
    """The picture as SVG."""
    order = [room for row in layers() for room in row]
    imported = imports(order)
    column = {room: NAME + TEXT + CELL * (k + 0.5) for k, room in enumerate(order)}
    line = {room: HEAD + CELL * (k + 0.5) for k, room in enumerate(order)}
    width, height = NAME + TEXT + CELL * len(order) + 10, HEAD + CELL * len(order) + 10
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" font-family="sans-serif" font-size="13" fill="#1b2450">',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    first = 0
    for i, row in enumerate(layers()):
        y, size = HEAD + CELL * first, CELL * len(row)
        colour = "#ffffff" if i % 2 else "#f1f4fb"
        out.append(f'<rect x="0" y="{y}" width="{width}" height="{size}" fill="{colour}"/>')
        first += len(row)
    for room in order:
        y, x = line[room], column[room]
        out.append(f'<text x="10" y="{y + 4.5}" font-weight="bold">{room}</text>')
        out.append(f'<text x="{NAME}" y="{y + 4.5}" fill="#445">{escape(summary(room))}</text>')
        out.append(
            f'<text transform="translate({x + 4.5} {HEAD - 8}) rotate(-60)">{room}</text>'
            f'<path d="M{x} {HEAD}V{height - 10}" stroke="#dfe3ef"/>'
            f'<rect x="{x - 6}" y="{y - 6}" width="12" height="12" fill="#c3c9dd"/>'
        )
    for room in order:
        for target in sorted(imported[room]):
            out.append(
                f'<circle cx="{column[target]}" cy="{line[room]}" r="5.5" fill="#3f51b5">'
                f"<title>{room} imports {target}</title></circle>"
            )
    return "\n".join([*out, "</svg>", ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only compare with the file")
    check = parser.parse_args().check
    text = drawing()
    if check:
        return 0 if PICTURE.exists() and PICTURE.read_text("utf-8") == text else 1
    PICTURE.write_text(text, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
