"""Does the file describe one tree of links, and may its base float?"""

from __future__ import annotations

from wbc.errors import did_you_mean
from wbc.robot.finding import Finding
from wbc.robot.model import KINDS, world_joint
from wbc.robot.urdf import Urdf, UrdfJoint


def check_tree(urdf: Urdf) -> list[Finding]:
    """Duplicate and missing names, unusable joints, loops, loose links, a bolted base."""
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
    if joint.kind not in KINDS:
        findings.append(
            Finding(
                "error",
                joint.name,
                f"has the type '{joint.kind}' {place}",
                "its motion is undefined",
                f"use one of {', '.join(KINDS)}",
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
    elif joint.kind in ("floating", "planar") and joint is not world_joint(urdf):
        findings.append(
            Finding(
                "error",
                joint.name,
                f"is {joint.kind} inside the robot {place}",
                "nothing drives its six or three directions",
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
    # The base is the root from which most of the robot hangs.
    sizes = {root: len(urdf.below(root)) for root in roots}
    base = max(roots, key=lambda root: sizes[root])
    findings = [
        Finding(
            "error",
            root,
            f"hangs on no joint, beside the base '{base}'",
            "it and what hangs on it would fall off; the file is refused",
            f"add a joint that has '{root}' as its child",
            "disconnected-link",
        )
        for root in roots
        if root != base
    ]
    seen = set().union(*(urdf.below(root) for root in roots))
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
    anchor = world_joint(urdf)
    if anchor is not None and anchor.kind == "fixed":
        findings.append(
            Finding(
                "warning",
                anchor.name,
                f"bolts '{anchor.child}' to '{anchor.parent}': the file has no floating base",
                "a humanoid would hang in the air; the joint is left out and the base floats",
                f"remove the link '{anchor.parent}' and the joint",
                "no-floating-base",
            )
        )
    elif anchor is not None:
        findings.append(
            Finding(
                "note",
                anchor.name,
                "is the file's own floating joint",
                "the library's free-flyer takes its place",
                "nothing, or remove it",
                "own-floating-base",
            )
        )
    return findings
