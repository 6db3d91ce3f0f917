"""The HTML page around meshcat's viewer: as served by a process, or as a file."""

from __future__ import annotations

import html
import importlib.util
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from string import Template
from typing import Any

from wbc.runtime.snapshot import Snapshot
from wbc.view.colours import COM, LEGEND, STATUS, Colour, css
from wbc.view.errors import ViewerError

_HERE = Path(__file__).parent / "page"
_PHASES = {
    "stand": "standing",
    "double": "double support",
    "left": "left stance",
    "right": "right stance",
    "flight": "flight",
    "falling": "falling",
}
_SYMBOLS = {
    "line": '<rect x="1" y="5" width="18" height="4" rx="2" fill="{0}"/>',
    "disc": '<circle cx="10" cy="7" r="5" fill="{0}"/>',
    "ring": '<circle cx="10" cy="7" r="4.5" fill="none" stroke="{0}" stroke-width="2"/>',
    "area": '<rect x="2" y="2" width="16" height="10" fill="{0}" fill-opacity=".3" stroke="{0}" '
    'stroke-width="1.5"/>',
    "box": '<rect x="2" y="3" width="16" height="8" fill="none" stroke="{0}" stroke-width="2"/>',
    "dots": '<g fill="{0}"><circle cx="4" cy="9" r="1.7"/><circle cx="10" cy="5" r="1.7"/>'
    '<circle cx="16" cy="9" r="1.7"/></g>',
}


def viewer_scripts(*names: str) -> list[Path]:
    """Return the paths of meshcat's script, of the scene's script and of further ones."""
    return [_meshcat_script(), *(_HERE / name for name in ("scene.js", *names))]


@cache
def _meshcat_script() -> Path:
    """Return the path of the script of the meshcat package.

    Raises:
        ViewerError: meshcat is not installed, or its script is not where it is expected.
    """
    # meshcat is not imported: that takes half a second, and only this file is needed.
    found = importlib.util.find_spec("meshcat")
    for folder in (found.submodule_search_locations or ()) if found is not None else ():
        path = Path(folder) / "viewer" / "dist" / "main.min.js"
        if path.is_file():
            return path
    raise ViewerError("meshcat's page was not found; run  pip install 'meshcat>=0.3.2,<0.4'")


def served_page(name: str, files: Sequence[Path]) -> str:
    """Return a page that loads its files, objects and frames from a server.

    Args:
        name: Name of the robot.
        files: Paths of its scripts and style sheets.
    """
    tags = (
        f'<link rel="stylesheet" href="{path.name}">'
        if path.suffix == ".css"
        else f'<script src="{path.name}"></script>'
        for path in files
    )
    return _page(name, tags)


def offline_page(name: str, data: dict[str, str], files: Sequence[Path]) -> str:
    """Return a page that contains everything.

    Args:
        name: Name of the robot.
        data: Texts without `</` that the scripts read, by the ids of their elements.
        files: Paths of its scripts.
    """
    tags = [f'<script type="text/plain" id="{key}">{text}</script>' for key, text in data.items()]
    tags += [f"<script>{path.read_text('utf-8')}</script>" for path in files]
    return _page(name, tags)


def _page(name: str, tags: Iterable[str]) -> str:
    template = Template((_HERE / "page.html").read_text("utf-8"))
    return template.substitute(
        title=html.escape(f"{name} · wbc"),
        name=html.escape(name),
        style=(_HERE / "page.css").read_text("utf-8"),
        legend="".join(_legend_entry(*entry) for entry in LEGEND),
        scripts="\n".join(tags),
    )


def _legend_entry(symbol: str, colour: Colour, meaning: str) -> str:
    # The colour of the CoM is that of the text, also on a dark page.
    drawing = _SYMBOLS[symbol].format("currentColor" if colour == COM else css(colour))
    return f'<div><svg viewBox="0 0 20 14">{drawing}</svg>{html.escape(meaning)}</div>'


def caption(snapshot: Snapshot) -> dict[str, Any]:
    """Return the texts of a snapshot that the page shows."""
    return {
        "time": round(float(snapshot.time), 4),
        "run": snapshot.run,
        "status": snapshot.status.value,
        "colour": css(STATUS[snapshot.status]),
        "phase": _PHASES.get(snapshot.telemetry.phase, snapshot.telemetry.phase),
        "text": snapshot.text,
    }
