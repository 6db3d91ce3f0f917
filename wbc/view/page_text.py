"""The HTML page around meshcat's viewer, for the live viewer and for recordings."""

from __future__ import annotations

import html
import importlib.util
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from string import Template
from typing import Any

from wbc.runtime.snapshot import Snapshot
from wbc.view.colours import LEGEND, STATUS, css
from wbc.view.errors import ViewerError
from wbc.view.objects import Colour

_HERE = Path(__file__).parent / "page"
_PHASES = {
    "stand": "standing",
    "double": "double support",
    "left": "left stance",
    "right": "right stance",
    "flight": "flight",
}
_MARKS = {
    "line": '<rect x="1" y="5" width="18" height="4" rx="2" fill="{0}"/>',
    "disc": '<circle cx="10" cy="7" r="5" fill="{0}"/>',
    "ring": '<circle cx="10" cy="7" r="4.5" fill="none" stroke="{0}" stroke-width="2"/>',
    "area": '<rect x="2" y="2" width="16" height="10" fill="{0}" fill-opacity=".3" stroke="{0}" '
    'stroke-width="1.5"/>',
    "box": '<rect x="2" y="3" width="16" height="8" fill="none" stroke="{0}" stroke-width="2"/>',
    "dots": '<g fill="{0}"><circle cx="4" cy="9" r="1.7"/><circle cx="10" cy="5" r="1.7"/>'
    '<circle cx="16" cy="9" r="1.7"/></g>',
}


def served_page(name: str, sources: Sequence[str]) -> str:
    """Return a page that loads its scripts, objects and frames from a server.

    Args:
        name: Name of the robot.
        sources: Names of the scripts.
    """
    return _page(name, "".join(f'<script src="{source}"></script>\n' for source in sources))


def recorded_page(name: str, story: dict[str, Any], scene: str) -> str:
    """Return a self-contained page.

    Args:
        name: Name of the robot.
        story: Scale, paths, first poses and captions of the recording.
        scene: Commands of the recording, gzip and base64.
    """
    text = json.dumps(story, separators=(",", ":")).replace("</", "<\\/")
    scripts = [
        f'<script type="application/json" id="story">{text}</script>',
        f'<script type="text/plain" id="scene">{scene}</script>',
        *(f"<script>{script(s)}</script>" for s in ("meshcat.js", "stage.js", "replay.js")),
    ]
    return _page(name, "\n".join(scripts))


def _page(name: str, scripts: str) -> str:
    template = Template((_HERE / "page.html").read_text("utf-8"))
    return template.substitute(
        title=html.escape(f"{name} · wbc"),
        name=html.escape(name),
        style=(_HERE / "page.css").read_text("utf-8"),
        legend="".join(_entry(*entry) for entry in LEGEND),
        scripts=scripts,
    )


def _entry(mark: str, colour: Colour, meaning: str) -> str:
    drawing = _MARKS[mark].format(css(colour))
    return f'<div><svg viewBox="0 0 20 14">{drawing}</svg>{html.escape(meaning)}</div>'


@cache
def script(name: str) -> str:
    """Return a script of the page; `meshcat.js` is that of the meshcat package.

    Raises:
        ViewerError: meshcat is not installed, or its page is not where it is expected.
    """
    if name != "meshcat.js":
        return (_HERE / name).read_text("utf-8")
    # meshcat is not imported: that takes half a second, and only this file is needed.
    found = importlib.util.find_spec("meshcat")
    folders = list(found.submodule_search_locations or ()) if found is not None else []
    for folder in folders:
        path = Path(folder) / "viewer" / "dist" / "main.min.js"
        if path.is_file():
            return path.read_text("utf-8")
    raise ViewerError("meshcat's page was not found; run  pip install 'meshcat>=0.3.2,<0.4'")


def caption(snapshot: Snapshot) -> dict[str, Any]:
    """Return the texts of a snapshot that the page shows."""
    return {
        "time": round(float(snapshot.time), 4),
        "status": snapshot.status.value,
        "colour": css(STATUS[snapshot.status]),
        "phase": _PHASES.get(snapshot.telemetry.phase, snapshot.telemetry.phase),
        "text": snapshot.text,
    }
