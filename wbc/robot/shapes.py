"""Visual and collision elements of a URDF: which are sound, and what is wrong with the others."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from wbc.errors import RobotDescriptionError
from wbc.robot.urdf import Urdf

# The sizes that each shape must state, with their number of values.
SIZES = {
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "mesh": {},
}


def shape_of(element: ET.Element) -> ET.Element | None:
    """The `<box>`, `<mesh>`, … of a `<visual>` or `<collision>`."""
    geometry = element.find("geometry")
    return next(iter(geometry), None) if geometry is not None else None


def fault(urdf: Urdf, element: ET.Element) -> str | None:
    """What is wrong with a `<visual>` or `<collision>`; None if nothing is."""
    shape = shape_of(element)
    if shape is None:
        return f"a <{element.tag}> (line {urdf.line(element)}) has no geometry"
    where = f"the <{shape.tag}> of a <{element.tag}> (line {urdf.line(shape)})"
    if shape.tag not in SIZES:
        return f"{where} is no shape of URDF"
    try:
        origin = element.find("origin")
        urdf.numbers(origin, "xyz", (0.0,) * 3)
        urdf.numbers(origin, "rpy", (0.0,) * 3)
        for key, count in SIZES[shape.tag].items():
            if min(urdf.numbers(shape, key, (0.0,) * count)) <= 0.0:
                return f"{where} has no positive {key}"
        urdf.numbers(shape, "scale", (1.0,) * 3)
    except RobotDescriptionError as error:
        return f"{where} cannot be read ({str(error).partition(': ')[2].partition('; ')[0]})"
    if shape.tag == "mesh" and not shape.get("filename"):
        return f"{where} has no filename"
    return None


def material(urdf: Urdf, element: ET.Element | None, name: str) -> ET.Element | None:
    """A `<material>` that every reader accepts: a name, and a colour if it has a readable one."""
    if element is None:
        return None
    clean = ET.Element("material", name=element.get("name") or name)
    color = element.find("color")
    try:
        rgba = urdf.numbers(color, "rgba", (0.0,) * 4) if color is not None else None
    except RobotDescriptionError:
        rgba = None
    if rgba is not None:
        text = " ".join(repr(min(max(value, 0.0), 1.0)) for value in rgba)
        ET.SubElement(clean, "color", rgba=text)
    return clean
