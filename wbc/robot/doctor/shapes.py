"""Can the visual and collision shapes be read?"""

from __future__ import annotations

from wbc.robot.finding import Finding
from wbc.robot.shapes import fault
from wbc.robot.urdf import Urdf


def check_shapes(urdf: Urdf) -> list[Finding]:
    """Shapes without geometry, size or readable numbers."""
    return [
        Finding(
            "warning",
            name,
            what,
            "the shape is left out: it is not drawn, and a foot does not stand on it",
            "state a box, cylinder, sphere or mesh with its sizes in m",
            "broken-shape",
        )
        for name, link in urdf.links.items()
        for tag in ("visual", "collision")
        for element in link.findall(tag)
        if (what := fault(urdf, element)) is not None
    ]
