"""From a parsed URDF to a floating-base Pinocchio model.

Pinocchio is given a document of links, joints and inertias only. That keeps
meshes out of it, and lets what its reader refuses (a limit without an effort,
a revolute joint without a limit) or would model unusably (a continuous joint
of two coordinates, a base that the file bolts to the world) be put right first.
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

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
WORLD_JOINTS = ("fixed", "floating")
ROOT_JOINT = "root_joint"
# A revolute joint that states no range: one turn each way is more than any limb has.
NO_RANGE = math.pi


def build_model(urdf: Urdf, fixed: Iterable[str] = ()) -> pin.Model:
    """The model with a free-flyer root; each joint after it has one coordinate.

    Args:
        urdf: the description.
        fixed: names or patterns of joints to weld at zero.

    Raises:
        RobotDescriptionError: the tree is broken or Pinocchio refuses it.
    """
    check_tree(urdf)
    text = ET.tostring(document(urdf, tuple(fixed)), encoding="unicode")
    try:
        model = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    except Exception as error:
        raise RobotDescriptionError(
            f"{urdf.path}: Pinocchio cannot build a model of it ({error}); "
            f"run  wbc doctor {urdf.path}"
        ) from error
    for joint in urdf.joints:
        if joint.kind == "continuous" and model.existJointName(joint.name):
            index = model.joints[model.getJointId(joint.name)].idx_q
            lower, upper = model.lowerPositionLimit, model.upperPositionLimit
            lower[index], upper[index] = -np.inf, np.inf
            model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    return model


def check_tree(urdf: Urdf) -> None:
    """Refuse a file whose links and joints are not one tree.

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
        if joint.kind not in KINDS:
            raise RobotDescriptionError(
                f"{where} has the type '{joint.kind}'; it must be one of {', '.join(KINDS)}"
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
            f"{urdf.path}: the links {', '.join(repr(r) for r in roots)} hang on no joint, "
            "so the robot falls into pieces; join all but the base with a joint"
        )
    stray = [link for link in urdf.links if link not in urdf.below(roots[0])]
    if stray:
        raise RobotDescriptionError(
            f"{urdf.path}: the joints of the links {', '.join(repr(s) for s in stray[:4])} form "
            "a loop apart from the base; remove one joint of the loop"
        )
    anchor = world_joint(urdf)
    for joint in urdf.joints:
        if joint.kind in ("floating", "planar") and joint is not anchor:
            raise RobotDescriptionError(
                f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}' is "
                f"{joint.kind}; only the base may float, split it into single joints"
            )


def world_joint(urdf: Urdf) -> UrdfJoint | None:
    """The joint by which the file hangs the robot on a massless `world`, if it does."""
    roots = urdf.roots()
    if len(roots) != 1 or len(urdf.links[roots[0]]):
        return None
    hanging = [joint for joint in urdf.joints if joint.parent == roots[0]]
    if len(hanging) == 1 and hanging[0].kind in WORLD_JOINTS:
        bolted = hanging[0].kind == "floating" or roots[0].lower() in ("world", "map", "odom")
        return hanging[0] if bolted else None
    return None


def document(urdf: Urdf, fixed: tuple[str, ...] = ()) -> ET.Element:
    """The file reduced to its links, inertias and joints, complete and in readable numbers."""
    robot = ET.Element("robot", name=urdf.element.get("name") or urdf.path.stem)
    anchor = world_joint(urdf)
    for name, element in urdf.links.items():
        if anchor is None or name != anchor.parent:
            link = ET.SubElement(robot, "link", name=name)
            inertial = element.find("inertial")
            if inertial is not None:
                link.append(_inertial(urdf, name, inertial))
    for joint in urdf.joints:
        if joint is not anchor:
            welded = any(fnmatchcase(joint.name, pattern) for pattern in fixed)
            robot.append(_joint(urdf, joint, welded))
    return robot


def _inertial(urdf: Urdf, name: str, inertial: ET.Element) -> ET.Element:
    """A complete `<inertial>`: the reader refuses one that lacks a mass or an inertia."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    where = f"{urdf.path}, line {urdf.line(inertial)}: link '{name}'"
    kilograms = urdf.numbers(mass, "value", (0.0,))[0]
    tensor = {
        key: urdf.numbers(inertia, key, (0.0,))[0]
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    }
    if kilograms < 0.0:
        raise RobotDescriptionError(f"{where} has the mass {kilograms} kg; it must be positive")
    whole = ET.Element("inertial")
    ET.SubElement(whole, "origin", _origin(urdf, inertial.find("origin")))
    ET.SubElement(whole, "mass", value=repr(kilograms))
    ET.SubElement(whole, "inertia", {key: repr(value) for key, value in tensor.items()})
    return whole


def _joint(urdf: Urdf, joint: UrdfJoint, welded: bool) -> ET.Element:
    kind = "revolute" if joint.kind == "continuous" else joint.kind
    kind = "fixed" if welded else kind
    clean = ET.Element("joint", name=joint.name, type=kind)
    ET.SubElement(clean, "origin", _origin(urdf, joint.element.find("origin")))
    ET.SubElement(clean, "parent", link=joint.parent)
    ET.SubElement(clean, "child", link=joint.child)
    if kind == "fixed":
        return clean
    where = f"{urdf.path}, line {urdf.line(joint.element)}: joint '{joint.name}'"
    axis = urdf.numbers(joint.element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    if math.hypot(*axis) < 1e-6:
        raise RobotDescriptionError(f"{where} has an axis of length zero; state a direction")
    ET.SubElement(clean, "axis", xyz=_text(axis))
    limit = joint.element.find("limit")
    values = {
        key: urdf.numbers(limit, key, (0.0,))[0] for key in ("lower", "upper", "effort", "velocity")
    }
    if joint.kind == "continuous" or has_no_range(joint):
        values["lower"], values["upper"] = -NO_RANGE, NO_RANGE
    if values["lower"] > values["upper"]:
        raise RobotDescriptionError(
            f"{where} has a lower limit {values['lower']:g} above its upper {values['upper']:g}; "
            "exchange them"
        )
    ET.SubElement(clean, "limit", {key: repr(value) for key, value in values.items()})
    return clean


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
