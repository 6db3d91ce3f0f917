"""Checks of the tree: names, joint types, loops, unconnected links, a fixed base."""

from __future__ import annotations

from wbc.errors import did_you_mean
from wbc.robot.finding import Finding
from wbc.robot.model import JOINT_TYPES, world_joint
from wbc.robot.urdf import Urdf, UrdfJoint


def check_tree(urdf: Urdf) -> list[Finding]:
    """Return findings on names, joint types, loops, unconnected links and a fixed base."""
    findings = [
        Finding(
            "error",
            name,
            f"a second {tag} of this name (line {line})",
            "which of the two a joint or a task means is undefined, and the file is refused",
            f"rename one {tag}",
            "duplicate-name",
        )
        for tag, name, line in urdf.duplicates()
    ]
    reached: dict[str, UrdfJoint] = {}
    for joint in urdf.joints:
        findings += _joint(urdf, joint, reached)
    return findings + _roots(urdf, reached)


def _joint(urdf: Urdf, joint: UrdfJoint, reached: dict[str, UrdfJoint]) -> list[Finding]:
    place = f"(line {urdf.line(joint.element)})"
    findings = []
    for link in (joint.parent, joint.child):
        if link not in urdf.links:
            findings.append(
                Finding(
                    "error",
                    joint.name,
                    f"names the link '{link}', which the file does not have {place}",
                    "the tree cannot be built",
                    f"add the link or correct the name{did_you_mean(link, urdf.links)}",
                    "missing-link",
                )
            )
    if joint.type not in JOINT_TYPES:
        findings.append(
            Finding(
                "error",
                joint.name,
                f"has the type '{joint.type}' {place}",
                "its motion is undefined",
                f"use one of {', '.join(JOINT_TYPES)}",
                "unknown-joint-type",
            )
        )
    if joint.child in reached:
        findings.append(
            Finding(
                "error",
                joint.name,
                f"is a second joint into the link '{joint.child}' {place}; "
                f"'{reached[joint.child].name}' is the first",
                "the links form a loop, and a URDF is a tree",
                "remove one of them, or split the link in two",
                "loop",
            )
        )
    elif joint.type in ("floating", "planar") and joint is not world_joint(urdf):
        findings.append(
            Finding(
                "error",
                joint.name,
                f"is {joint.type} inside the robot {place}",
                "it has several axes and no motors",
                "split it into single revolute and prismatic joints, or make it fixed",
                "inner-floating-joint",
            )
        )
    reached.setdefault(joint.child, joint)
    return findings


def _roots(urdf: Urdf, reached: dict[str, UrdfJoint]) -> list[Finding]:
    roots = urdf.roots()
    if not roots:
        return [
            Finding(
                "error",
                urdf.path.name,
                "every link is some joint's child",
                "the joints form a loop without a base, so no tree can be built",
                "remove the joint into the base link",
                "loop",
            )
        ]
    # The base is the root with the most links.
    sizes = {root: len(urdf.descendants(root)) for root in roots}
    base = max(roots, key=lambda root: sizes[root])
    findings = [
        Finding(
            "error",
            root,
            f"is no joint's child, and neither is the base '{base}'",
            "it is not connected to the robot; the file is refused",
            f"add a joint that has '{root}' as its child",
            "disconnected-link",
        )
        for root in roots
        if root != base
    ]
    seen = set().union(*(urdf.descendants(root) for root in roots))
    findings += [
        Finding(
            "error",
            link,
            "cannot be reached from the base: its joints form a loop",
            "the tree cannot be built",
            "remove one joint of the loop",
            "loop",
        )
        for link in urdf.links
        if link not in seen
    ]
    fixture = world_joint(urdf)
    if fixture is not None and fixture.type == "fixed":
        findings.append(
            Finding(
                "warning",
                fixture.name,
                f"fixes '{fixture.child}' to '{fixture.parent}': the file has no floating base",
                "a humanoid could not move; the joint is left out and the base floats",
                f"remove the link '{fixture.parent}' and the joint",
                "no-floating-base",
            )
        )
    elif fixture is not None:
        findings.append(
            Finding(
                "note",
                fixture.name,
                "is the file's own floating joint",
                "the library's free-flyer takes its place",
                "no change is needed",
                "own-floating-base",
            )
        )
    return findings
