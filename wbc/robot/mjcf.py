"""MJCF files: read by Pinocchio, and written as the URDF document that the loader works on.

Bodies become links, and a body with several joints becomes a chain of links. Effort limits come
from `actuatorfrcrange` of a joint, or from `forcerange`, or `ctrlrange` and `gear`, of its motor.
Keyframes become postures, as an SRDF has them.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError

_COMPOSITE = "JointModelComposite"


class _Axis(NamedTuple):
    """A joint of one degree of freedom, and where it is on the one before."""

    name: str
    placement: pin.SE3
    sliding: bool
    axis: np.ndarray


def urdf_of_mjcf(path: Path, root: ET.Element) -> ET.Element:
    """Return the URDF document of an MJCF file.

    Args:
        path: the file.
        root: its `<mujoco>` element.

    Raises:
        RobotDescriptionError: Pinocchio cannot read it, or it has a ball joint or several bodies.
    """
    try:
        model = pin.buildModelFromMJCF(str(path))
        shapes = {
            tag: pin.buildGeomFromMJCF(model, str(path), kind)
            for tag, kind in (("visual", pin.VISUAL), ("collision", pin.COLLISION))
        }
    except Exception as error:
        raise RobotDescriptionError(
            f"{path}: Pinocchio cannot read this MJCF file ({' '.join(str(error).split())}); "
            "give a URDF of the robot, or simplify the file"
        ) from error
    robot = ET.Element("robot", name=root.get("model") or path.stem)
    links = {joint: _link_name(model, joint) for joint in range(1, model.njoints)}
    first = 1 if model.joints[1].shortname() == "JointModelFreeFlyer" else 0
    if first == 0:
        links[0] = "world"
        ET.SubElement(robot, "link", name="world")
    efforts, places = _efforts(root), dict[str, int]()
    for joint in range(1, model.njoints):
        if joint > first:
            parent = links[model.parents[joint]]
            axes = list(_axes(path, root, model, joint, links[joint]))
            for k, axis in enumerate(axes):
                child = links[joint] if k == len(axes) - 1 else f"{links[joint]}_{k}"
                if child != links[joint]:
                    ET.SubElement(robot, "link", name=child)
                robot.append(_joint(model, joint, k, axis, parent, child, efforts))
                places[axis.name] = model.idx_qs[joint] + k
                parent = child
        link = ET.SubElement(robot, "link", name=links[joint])
        link.append(_inertial(model.inertias[joint]))
        for tag, geometry in shapes.items():
            for shape in geometry.geometryObjects:
                if shape.parentJoint == joint:
                    _add_shape(link, tag, shape)
    for frame in model.frames:
        name, joint = str(frame.name), frame.parentJoint
        if frame.type == pin.BODY and joint in links and name != links[joint]:
            ET.SubElement(robot, "link", name=name)
            fixed = ET.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
            fixed.append(_origin(frame.placement))
            ET.SubElement(fixed, "parent", link=links[joint])
            ET.SubElement(fixed, "child", link=name)
    for keyframe in model.referenceConfigurations:
        state = ET.SubElement(robot, "group_state", name=str(keyframe.key()))
        for name, place in places.items():
            ET.SubElement(state, "joint", name=name, value=repr(float(keyframe.data()[place])))
    return robot


def _link_name(model: pin.Model, joint: int) -> str:
    names = (str(f.name) for f in model.frames if f.parentJoint == joint and f.type == pin.BODY)
    return next(names, f"{model.names[joint]}_link")


def _axes(path: Path, root: ET.Element, model: pin.Model, joint: int, body: str) -> Iterator[_Axis]:
    """Yield the joints of one degree of freedom that a joint of the model consists of."""
    whole, placement = model.joints[joint], model.jointPlacements[joint]
    if whole.shortname() != _COMPOSITE:
        yield _axis(path, str(model.names[joint]), whole, placement)
        return
    element = next((b for b in root.iter("body") if b.get("name") == body), None)
    names = [j.get("name") for j in element.findall("joint")] if element is not None else []
    composite = whole.extract() if hasattr(whole, "extract") else whole
    for k, part in enumerate(composite.joints):
        name = (names[k] if k < len(names) else None) or f"{body}_joint_{k}"
        yield _axis(path, name, part, placement * composite.jointPlacements[k])
        placement = pin.SE3.Identity()


def _axis(path: Path, name: str, joint: pin.JointModel, placement: pin.SE3) -> _Axis:
    if joint.nv != 1 or joint.nq != 1:
        raise RobotDescriptionError(
            f"{path}: joint '{name}' has {joint.nv} degrees of freedom ({joint.shortname()}); "
            "split it into hinge and slide joints"
        )
    data = joint.createData()
    # A joint on its own is the first and only one of its configuration.
    joint = joint.copy() if hasattr(joint, "copy") else joint
    joint.setIndexes(0, 0, 0)
    joint.calc(data, np.zeros(1))
    S = np.asarray(data.S).reshape(6)
    sliding = bool(np.abs(S[:3]).max() > 0.5)
    return _Axis(name, placement, sliding, S[:3] if sliding else S[3:])


def _joint(
    model: pin.Model,
    joint: int,
    part: int,
    axis: _Axis,
    parent: str,
    child: str,
    efforts: dict[str, float],
) -> ET.Element:
    q, v = model.idx_qs[joint] + part, model.idx_vs[joint] + part
    lower, upper = float(model.lowerPositionLimit[q]), float(model.upperPositionLimit[q])
    limited = math.isfinite(lower) and math.isfinite(upper) and upper - lower < 1e3
    kind = "prismatic" if axis.sliding else "revolute" if limited else "continuous"
    element = ET.Element("joint", name=axis.name, type=kind)
    element.append(_origin(axis.placement))
    ET.SubElement(element, "parent", link=parent)
    ET.SubElement(element, "child", link=child)
    ET.SubElement(element, "axis", xyz=_text(axis.axis))
    effort, velocity = float(model.effortLimit[v]), float(model.velocityLimit[v])
    limit = {"effort": effort if math.isfinite(effort) else efforts.get(axis.name, 0.0)}
    limit["velocity"] = velocity if math.isfinite(velocity) and velocity < 1e6 else 0.0
    if limited:
        limit |= {"lower": lower, "upper": upper}
    ET.SubElement(element, "limit", {key: repr(value) for key, value in limit.items()})
    return element


def _efforts(root: ET.Element) -> dict[str, float]:
    """Return the force limits of the actuators, by joint; N·m or N."""
    efforts: dict[str, float] = {}
    for actuator in root.iterfind("actuator/*"):
        joint = actuator.get("joint")
        if joint is None:
            continue
        gear = abs(float((actuator.get("gear") or "1").split()[0]))
        forces = actuator.get("forcerange")
        if forces is None and actuator.tag == "motor":
            forces = actuator.get("ctrlrange")
        if forces is not None:
            efforts[joint] = gear * max(abs(float(word)) for word in forces.split())
    return efforts


def _inertial(inertia: pin.Inertia) -> ET.Element:
    element = ET.Element("inertial")
    element.append(_origin(pin.SE3(np.eye(3), np.array(inertia.lever))))
    ET.SubElement(element, "mass", value=repr(float(inertia.mass)))
    I = inertia.inertia  # noqa: E741
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    values = {key: repr(float(I[place])) for key, place in (keys | {"izz": (2, 2)}).items()}
    ET.SubElement(element, "inertia", values)
    return element


def _add_shape(link: ET.Element, tag: str, shape: pin.GeometryObject) -> None:
    """Add a shape to its link; planes and other shapes without a size are left out."""
    solid = shape.geometry
    kind = type(solid).__name__
    if kind == "Box":
        size = {"size": _text(2.0 * np.asarray(solid.halfSide))}
    elif kind == "Sphere":
        size = {"radius": repr(float(solid.radius))}
    elif kind in ("Cylinder", "Capsule"):
        size = {"radius": repr(float(solid.radius)), "length": repr(2.0 * float(solid.halfLength))}
    elif shape.meshPath and Path(shape.meshPath).is_file():
        kind = "mesh"
        size = {"filename": str(shape.meshPath), "scale": _text(np.asarray(shape.meshScale))}
    else:
        return
    element = ET.SubElement(link, tag)
    element.append(_origin(shape.placement))
    ET.SubElement(ET.SubElement(element, "geometry"), kind.lower(), size)


def _origin(placement: pin.SE3) -> ET.Element:
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    return ET.Element("origin", xyz=_text(placement.translation), rpy=_text(rpy))


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)
