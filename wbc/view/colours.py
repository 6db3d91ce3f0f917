"""The colours of the scene and their meaning, from which the page's legend is made."""

from __future__ import annotations

from wbc.command import Status

#: Red, green, blue and opacity, 0 to 1.
Colour = tuple[float, float, float, float]


def rgb(text: str) -> Colour:
    """Return the opaque colour `#rrggbb`."""
    red, green, blue = bytes.fromhex(text[1:])
    return (red / 255, green / 255, blue / 255, 1.0)


FORCE = rgb("#d1342b")
COM = rgb("#23272f")
DCM = rgb("#7a3fc4")
ZMP = rgb("#f0a202")
SUPPORT = rgb("#1f9d7a")
LEFT = rgb("#2467d6")
RIGHT = rgb("#e06a10")
SWING = rgb("#5b6472")
BARE = rgb("#8fa3b8")
TERRAIN = rgb("#cfd6dd")

STATUS: dict[Status, Colour] = {
    Status.OK: rgb("#2eaf5d"),
    Status.INFEASIBLE: rgb("#f0a202"),
    Status.FAILED: rgb("#d1342b"),
}

#: (symbol, colour, meaning); the symbol is `disc`, `ring`, `line`, `area` or `box`.
LEGEND: tuple[tuple[str, Colour, str], ...] = (
    ("line", FORCE, "contact force"),
    ("disc", COM, "centre of mass and its past path"),
    ("disc", DCM, "DCM (capture point)"),
    ("ring", DCM, "DCM reference"),
    ("disc", ZMP, "ZMP"),
    ("area", SUPPORT, "support polygon"),
    ("box", LEFT, "left footstep (faded: completed)"),
    ("box", RIGHT, "right footstep (faded: completed)"),
    ("dots", SWING, "swing path"),
)


def faded(colour: Colour, opacity: float) -> Colour:
    """Return the colour with the given opacity, 0 to 1."""
    return (*colour[:3], opacity)


def css(colour: Colour) -> str:
    """Return the colour in CSS notation."""
    red, green, blue, opacity = colour
    return f"rgba({round(255 * red)},{round(255 * green)},{round(255 * blue)},{opacity})"
