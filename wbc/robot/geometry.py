"""Visual and collision shapes of a URDF: their defects, and a Pinocchio geometry model of them."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.robot.model import normalized_document
from wbc.robot.packages import resolve, up_axis_rotation
from wbc.robot.urdf import Urdf

#: Bounding volumes of meshes, see `load_geometry`; the two kinds whose vertices Python can read.
VERTICES_ONLY, FOR_DISTANCES = coal.NODE_TYPE.BV_OBB, coal.NODE_TYPE.BV_OBBRSS
GRAY = "0.6 0.6 0.6 1.0"
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


def shape_defect(urdf: Urdf, element: ET.Element) -> str | None:
    """Return what is wrong with a `<visual>` or `<collision>`, or None."""
    shape = shape_of(element)
    if shape is None:
        return f"a <{element.tag}> (line {urdf.line(element)}) has no geometry"
    where = f"the <{shape.tag}> of a <{element.tag}> (line {urdf.line(shape)})"
    if shape.tag not in SIZES:
        return f"{where} is not a URDF shape"
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
    """Return a valid `<material>`: a name, and a colour if it has a readable one."""
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


def load_geometry(
    model: pin.Model,
    urdf: Urdf,
    kind: pin.GeometryType,
    folders: tuple[Path, ...],
    respect_up_axis: bool = False,
    tree: coal.NODE_TYPE = VERTICES_ONLY,
) -> pin.GeometryModel:
    """Return the shapes of a URDF, without broken ones and meshes that are not found.

    Args:
        model: the robot's model.
        urdf: the description.
        kind: the visual or the collision shapes.
        folders: where packages are looked for.
        respect_up_axis: turn meshes whose files state an up axis.
        tree: bounding volumes of the meshes' triangles. `VERTICES_ONLY` are the quickest to make
            and enough for drawing and hulls, `FOR_DISTANCES` takes most of the time and memory.

    Raises:
        RobotDescriptionError: a mesh file exists but cannot be read.
    """
    tag = "visual" if kind == pin.VISUAL else "collision"
    robot = normalized_document(urdf)
    defined = _materials(urdf)
    robot.extend(defined.values())
    for link in robot.findall("link"):
        for element in urdf.links[link.get("name", "")].findall(tag):
            if shape_defect(urdf, element) is None:
                shape = _shape(urdf, element, folders, respect_up_axis)
                if shape is not None:
                    _add_color(urdf, element, shape, defined)
                    link.append(shape)
    try:
        return pin.buildGeomFromUrdfString(
            model,
            ET.tostring(robot, encoding="unicode"),
            kind,
            package_dirs=["/"],
            mesh_loader=_mesh_loader(urdf.path, tree),
        )
    except Exception as error:
        raise RobotDescriptionError(
            f"{urdf.path}: its {tag} meshes cannot be read ({' '.join(str(error).split())}); "
            "repair or remove the mesh that is named"
        ) from error


@lru_cache(maxsize=4)
def _mesh_loader(description: Path, tree: coal.NODE_TYPE) -> coal.MeshLoader:
    """Return the loader of a description's meshes: G1's take 0.6 s, the second time 0.02 s.

    It reads a file again whose date has changed, which it knows to the second.
    """
    return coal.CachedMeshLoader(tree)


def _shape(
    urdf: Urdf, element: ET.Element, folders: tuple[Path, ...], respect_up_axis: bool
) -> ET.Element | None:
    """Return a copy of a shape with its mesh address replaced by a file; None without that file."""
    inner = shape_of(element)
    assert inner is not None
    inner = copy.deepcopy(inner)
    origin = element.find("origin")
    xyz = urdf.numbers(origin, "xyz", (0.0, 0.0, 0.0))
    rotation = pin.rpy.rpyToMatrix(*urdf.numbers(origin, "rpy", (0.0, 0.0, 0.0)))
    if inner.tag == "mesh":
        path = resolve(inner.get("filename", ""), urdf.path, folders)
        if path is None:
            return None
        inner.set("filename", str(path))
        if respect_up_axis:
            rotation = rotation @ up_axis_rotation(path)
    shape = ET.Element(element.tag)
    ET.SubElement(shape, "origin", xyz=_text(xyz), rpy=_text(pin.rpy.matrixToRpy(rotation)))
    ET.SubElement(shape, "geometry").append(inner)
    return shape


def _materials(urdf: Urdf) -> dict[str, ET.Element]:
    """Return the named colours of the file; those at its top precede those of the links."""
    found: dict[str, ET.Element] = {}
    top = urdf.element.findall("material")
    for element in (*top, *urdf.element.iterfind("link/visual/material")):
        clean = material(urdf, element, "unnamed")
        if clean is not None and len(clean):
            found.setdefault(clean.get("name", ""), clean)
    return found


def _add_color(
    urdf: Urdf, element: ET.Element, shape: ET.Element, defined: dict[str, ET.Element]
) -> None:
    """Add the colour of a visual: its own, the named one, or gray for an unknown name."""
    color = material(urdf, element.find("material"), "unnamed")
    if color is None or element.tag != "visual":
        return
    if not len(color) and color.get("name") not in defined:
        ET.SubElement(color, "color", rgba=GRAY)
    shape.append(color)


def _text(numbers: list[float] | np.ndarray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
