"""Writes a Pinocchio model as a URDF that any version of Pinocchio reads back."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

WIDE = 1e4  # rad, in place of an absent position limit
_AXES = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}


def urdf_text(model: pin.Model, frames: Mapping[str, int]) -> str:
    """Return a URDF of the bodies and joints, without shapes, and of some frames as links.

    Joints keep their names, and with them their order; a body is called after its joint.

    Args:
        model: free-flyer first, then joints of one coordinate.
        frames: name in the file -> index in the model.

    Raises:
        ValueError: a joint that a URDF cannot express.
    """
    robot = ET.Element("robot", name=model.name)
    for j in range(1, model.njoints):
        link = ET.SubElement(robot, "link", name=_body(model, j))
        link.append(_inertial(model.inertias[j]))
        if j > 1:
            robot.append(_joint(model, j))
    for name, index in frames.items():
        frame = model.frames[index]
        ET.SubElement(robot, "link", name=name)
        fixed = ET.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
        ET.SubElement(fixed, "parent", link=_body(model, frame.parentJoint))
        ET.SubElement(fixed, "child", link=name)
        ET.SubElement(fixed, "origin", _origin(frame.placement))
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def _body(model: pin.Model, joint: int) -> str:
    return f"{model.names[joint]}_body"


def _inertial(inertia: pin.Inertia) -> ET.Element:
    element = ET.Element("inertial")
    ET.SubElement(element, "origin", _origin(pin.SE3(np.eye(3), inertia.lever)))
    ET.SubElement(element, "mass", value=repr(float(inertia.mass)))
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    names["izz"] = (2, 2)
    tensor = {key: repr(float(inertia.inertia[at])) for key, at in names.items()}
    ET.SubElement(element, "inertia", tensor)
    return element


def _joint(model: pin.Model, j: int) -> ET.Element:
    joint = model.joints[j]
    kind = joint.shortname().removeprefix("JointModel")
    prismatic = kind.startswith("P")
    if kind[-1] in _AXES and kind[:-1] in ("R", "P", "RUB"):
        axis: tuple[float, ...] = _AXES[kind[-1]]
    elif kind in ("RevoluteUnaligned", "PrismaticUnaligned"):
        axis = tuple(joint.extract().axis if hasattr(joint, "extract") else joint.axis)
    else:
        raise ValueError(f"joint '{model.names[j]}' of type {kind} has no counterpart in a URDF")
    element = ET.Element("joint", name=model.names[j])
    element.set("type", "prismatic" if prismatic else "revolute")
    ET.SubElement(element, "parent", link=_body(model, model.parents[j]))
    ET.SubElement(element, "child", link=_body(model, j))
    ET.SubElement(element, "origin", _origin(model.jointPlacements[j]))
    ET.SubElement(element, "axis", xyz=_text(axis))
    limit = {
        "lower": max(model.lowerPositionLimit[joint.idx_q], -WIDE),
        "upper": min(model.upperPositionLimit[joint.idx_q], WIDE),
        "effort": model.effortLimit[joint.idx_v],
        "velocity": min(model.velocityLimit[joint.idx_v], WIDE),
    }
    ET.SubElement(element, "limit", {key: repr(float(v)) for key, v in limit.items()})
    return element


def _origin(placement: pin.SE3) -> dict[str, str]:
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    if not all(math.isfinite(angle) for angle in rpy):
        raise ValueError(f"a rotation without angles: {placement.rotation}")
    return {"xyz": _text(placement.translation), "rpy": _text(rpy)}


def _text(numbers: object) -> str:
    return " ".join(repr(float(number)) for number in numbers)  # type: ignore[attr-defined]
