"""Visual and collision shapes as a Pinocchio geometry model."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.robot.packages import resolve, up_axis_turn
from wbc.robot.urdf import Urdf, floats


def load_geometry(
    model: pin.Model,
    urdf: Urdf,
    kind: pin.GeometryType,
    folders: tuple[Path, ...],
    respect_up_axis: bool = False,
) -> pin.GeometryModel:
    """The shapes of a URDF, with meshes that cannot be found left out.

    Raises:
        RobotDescriptionError: a mesh is there but cannot be read.
    """
    tag = "visual" if kind == pin.VISUAL else "collision"
    robot = copy.deepcopy(urdf.element)
    for link in list(robot.findall("link")):
        # A base that the file hangs on the world: the model has no frame for the latter.
        if not model.existBodyName(link.get("name", "")):
            robot.remove(link)
            continue
        for shape in list(link.findall(tag)):
            if not _point_to_file(shape, urdf.path, folders, respect_up_axis):
                link.remove(shape)
    for joint in list(robot.findall("joint")):
        parent = joint.find("parent")
        if parent is not None and not model.existBodyName(parent.get("link", "")):
            robot.remove(joint)
    try:
        return pin.buildGeomFromUrdfString(
            model, ET.tostring(robot, encoding="unicode"), kind, package_dirs=["/"]
        )
    except Exception as error:
        raise RobotDescriptionError(
            f"{urdf.path}: its {tag} meshes cannot be read ({error}); "
            "repair or remove the mesh that is named"
        ) from error


def _point_to_file(
    shape: ET.Element, urdf: Path, folders: tuple[Path, ...], respect_up_axis: bool
) -> bool:
    """Replace a mesh's address by the path of its file; False if there is none."""
    mesh = shape.find("geometry/mesh")
    if mesh is None:
        return shape.find("geometry") is not None
    path = resolve(mesh.get("filename", ""), urdf, folders)
    if path is None:
        return False
    mesh.set("filename", str(path))
    turn = up_axis_turn(path) if respect_up_axis else np.eye(3)
    if not np.array_equal(turn, np.eye(3)):
        _turn(shape, turn)
    return True


def _turn(shape: ET.Element, turn: np.ndarray) -> None:
    """Turn a shape (3, 3) within its origin."""
    origin = shape.find("origin")
    if origin is None:
        origin = ET.SubElement(shape, "origin")
    rotation = pin.rpy.rpyToMatrix(*floats(origin, "rpy", (0.0, 0.0, 0.0)))
    rpy = pin.rpy.matrixToRpy(rotation @ turn)
    origin.set("rpy", " ".join(repr(float(angle)) for angle in rpy))
