"""From a parsed URDF to a floating-base Pinocchio model.

Pinocchio is given a document of links, joints and inertias only. Meshes are left out, and
what its reader refuses (a limit without an effort, a revolute joint without a limit) or models
unusably (a continuous joint of two coordinates, a base fixed to the world) is corrected first.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from fnmatch import fnmatchcase

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.robot.urdf import Urdf, UrdfJoint

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
WORLD_JOINT_TYPES = ("fixed", "floating")
ROOT_JOINT = "root_joint"
# Range of a revolute joint that states none, rad each way: more than any limb has.
DEFAULT_RANGE = math.pi


def build_model(urdf: Urdf, fixed: Iterable[str] = ()) -> pin.Model:
    """Return a model with a free-flyer root; each joint after it has one coordinate.

    Args:
        urdf: the description.
        fixed: names or patterns of joints to weld at zero.

    Raises:
        RobotDescriptionError: the tree is broken or Pinocchio refuses it.
    """
    check_tree(urdf)
    text = ET.tostring(normalized_document(urdf, tuple(fixed)), encoding="unicode")
    try:
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    except Exception as error:
        raise RobotDescriptionError(
            f"{urdf.path}: Pinocchio cannot build a model of it ({error}); "
            f"run  wbc doctor {urdf.path}"
        ) from error
    for joint in urdf.joints:
        if joint.type == "continuous" and model.existJointName(joint.name):
            index = model.joints[model.getJointId(joint.name)].idx_q
            lower, upper = model.lowerPositionLimit, model.upperPositionLimit
            lower[index], upper[index] = -np.inf, np.inf
            model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    return model


def check_tree(urdf: Urdf) -> None:
    """Check that the links and joints of a file form one tree.

    Raises:
        RobotDescriptionError: duplicate names, a joint that names no link, an
            unknown or unusable joint type, a loop, or several roots.
    """
    for tag, name, line in urdf.duplicates():
        raise RobotDescriptionError(
            f"{urdf.path}, line {line}: a second {tag} '{name}'; names must be unique, rename it"
        )
    parents: dict[str, str] = {}
    for joint in urdf.joints:
        where = f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}'"
        for link in (joint.parent, joint.child):
            if link not in urdf.links:
                raise RobotDescriptionError(
                    f"{where} names the link '{link}', which the file does not have; "
                    "add the link or correct the name"
                )
        if joint.type not in JOINT_TYPES:
            raise RobotDescriptionError(
                f"{where} has the type '{joint.type}'; it must be one of {', '.join(JOINT_TYPES)}"
            )
        if joint.child in parents:
            raise RobotDescriptionError(
                f"{where} is a second joint into the link '{joint.child}'; a URDF is a tree"
            )
        parents[joint.child] = joint.parent
    roots = urdf.roots()
    if not roots:
        raise RobotDescriptionError(f"{urdf.path}: the joints form a loop; a URDF is a tree")
    if len(roots) > 1:
        raise RobotDescriptionError(
            f"{urdf.path}: the links {', '.join(repr(r) for r in roots)} are no joint's child, "
            "so the file describes several bodies; add a joint to each link but the base"
        )
    unreachable = [link for link in urdf.links if link not in urdf.descendants(roots[0])]
    if unreachable:
        raise RobotDescriptionError(
            f"{urdf.path}: the joints of the links {', '.join(map(repr, unreachable[:4]))} form "
            "a loop that does not contain the base; remove one joint of the loop"
        )
    fixture = world_joint(urdf)
    for joint in urdf.joints:
        if joint.parent == roots[0] and joint is not fixture and is_world(urdf, roots[0]):
            raise RobotDescriptionError(
                f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}' moves the "
                f"base '{joint.child}' on the {joint.type} axis of the link '{roots[0]}', which "
                "stands for the world; a base floats or is fixed, so make the joint floating, or "
                "give that link mass"
            )
        if joint.type in ("floating", "planar") and joint is not fixture:
            raise RobotDescriptionError(
                f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}' is "
                f"{joint.type}; only the base may float, so split it into joints of one axis"
            )


def world_joint(urdf: Urdf) -> UrdfJoint | None:
    """Return the joint that connects the robot to a massless `world` link, or None."""
    roots = urdf.roots()
    if len(roots) != 1 or len(urdf.links[roots[0]]):
        return None
    joints = [joint for joint in urdf.joints if joint.parent == roots[0]]
    if len(joints) == 1 and joints[0].type in WORLD_JOINT_TYPES:
        connects = joints[0].type == "floating" or is_world(urdf, roots[0])
        return joints[0] if connects else None
    return None


def is_world(urdf: Urdf, link: str) -> bool:
    """Whether a link is empty and called as the world is."""
    return not len(urdf.links[link]) and link.lower() in ("world", "map", "odom")


def normalized_document(urdf: Urdf, fixed: tuple[str, ...] = ()) -> ET.Element:
    """Return the links, inertias and joints of a file, complete and with valid numbers."""
    robot = ET.Element("robot", name=urdf.element.get("name") or urdf.path.stem)
    fixture = world_joint(urdf)
    for name, element in urdf.links.items():
        if fixture is None or name != fixture.parent:
            link = ET.SubElement(robot, "link", name=name)
            inertial = element.find("inertial")
            if inertial is not None:
                link.append(_inertial(urdf, name, inertial))
    for joint in urdf.joints:
        if joint is not fixture:
            welded = any(fnmatchcase(joint.name, pattern) for pattern in fixed)
            robot.append(_joint(urdf, joint, welded))
    return robot


def _inertial(urdf: Urdf, name: str, inertial: ET.Element) -> ET.Element:
    """Return a complete `<inertial>`: Pinocchio refuses one without mass or inertia."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    where = f"{urdf.path}, line {urdf.line(inertial)}: link '{name}'"
    kilograms = urdf.numbers(mass, "value", (0.0,))[0]
    tensor = {
        key: urdf.numbers(inertia, key, (0.0,))[0]
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    }
    if kilograms < 0.0:
        raise RobotDescriptionError(f"{where} has the mass {kilograms} kg; it must be positive")
    complete = ET.Element("inertial")
    ET.SubElement(complete, "origin", _origin(urdf, inertial.find("origin")))
    ET.SubElement(complete, "mass", value=repr(kilograms))
    ET.SubElement(complete, "inertia", {key: repr(value) for key, value in tensor.items()})
    return complete


def _joint(urdf: Urdf, joint: UrdfJoint, welded: bool) -> ET.Element:
    kind = "revolute" if joint.type == "continuous" else joint.type
    kind = "fixed" if welded else kind
    normalized = ET.Element("joint", name=joint.name, type=kind)
    ET.SubElement(normalized, "origin", _origin(urdf, joint.element.find("origin")))
    ET.SubElement(normalized, "parent", link=joint.parent)
    ET.SubElement(normalized, "child", link=joint.child)
    if kind == "fixed":
        return normalized
    where = f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}'"
    axis = urdf.numbers(joint.element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    if math.hypot(*axis) < 1e-6:
        raise RobotDescriptionError(f"{where} has an axis of length zero; state a direction")
    ET.SubElement(normalized, "axis", xyz=_text(axis))
    limit = joint.element.find("limit")
    values = {
        key: urdf.numbers(limit, key, (0.0,))[0] for key in ("lower", "upper", "effort", "velocity")
    }
    if joint.type == "continuous" or has_no_range(joint):
        values["lower"], values["upper"] = -DEFAULT_RANGE, DEFAULT_RANGE
    if values["lower"] > values["upper"]:
        raise RobotDescriptionError(
            f"{where} has a lower limit {values['lower']:g} above its upper {values['upper']:g}; "
            "exchange lower and upper"
        )
    ET.SubElement(normalized, "limit", {key: repr(value) for key, value in values.items()})
    return normalized


def _origin(urdf: Urdf, origin: ET.Element | None) -> dict[str, str]:
    return {key: _text(urdf.numbers(origin, key, (0.0, 0.0, 0.0))) for key in ("xyz", "rpy")}


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(number) for number in numbers)


def has_no_range(joint: UrdfJoint) -> bool:
    """Whether a revolute or prismatic joint states no range (URDF's default is 0 to 0)."""
    limit = joint.element.find("limit")
    if limit is None:
        return True
    try:
        return all(float(limit.get(key, "0")) == 0.0 for key in ("lower", "upper"))
    except ValueError:
        return False
