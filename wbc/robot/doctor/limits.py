"""Checks of the joints' position, velocity and effort limits."""

from __future__ import annotations

import math

from wbc.errors import RobotDescriptionError
from wbc.robot.finding import Finding
from wbc.robot.model import has_no_range
from wbc.robot.urdf import Urdf, UrdfJoint

# Exporters write an effort this large on every joint as a placeholder, N·m.
PLACEHOLDER_EFFORT = 900.0
# No joint of a robot turns farther from its zero than this, rad: it must be degrees.
DEGREES = 12.0


def check_limits(urdf: Urdf) -> list[Finding]:
    """Return findings on absent, zero, empty and reversed limits, and on mimicking joints."""
    findings: list[Finding] = []
    for joint in urdf.joints:
        if joint.type in ("revolute", "prismatic", "continuous"):
            try:
                findings += _limits(urdf, joint)
            except RobotDescriptionError as error:
                findings.append(Finding.from_error(error, joint.name, "unreadable-number"))
    return findings + _placeholder_efforts(urdf)


def _limits(urdf: Urdf, joint: UrdfJoint) -> list[Finding]:
    limit = joint.element.find("limit")
    lower, upper, effort, velocity = (
        urdf.numbers(limit, key, (0.0,))[0] for key in ("lower", "upper", "effort", "velocity")
    )
    place = f"(line {urdf.line(joint.element)})"
    findings = []
    for value, what, unit, cure in (
        (effort, "effort", "an effort is assumed from the weight that it carries", "effort"),
        (velocity, "velocity", "it is taken as unlimited", "velocity"),
    ):
        if value <= 0.0:
            findings.append(
                Finding(
                    "warning",
                    joint.name,
                    f"its {what} limit is zero or absent {place}",
                    unit,
                    f"state <limit {cure}=…>, or {cure}_limits in a data file",
                    f"no-{what}-limit",
                )
            )
    if joint.type == "continuous":
        return findings
    if has_no_range(joint):
        findings.append(
            Finding(
                "warning",
                joint.name,
                f"has no position limits {place}",
                "a range of ±π is assumed, which may exceed what the joint can do",
                "state <limit lower=… upper=…>",
                "no-position-limit",
            )
        )
    elif lower > upper:
        findings.append(
            Finding(
                "error",
                joint.name,
                f"its lower limit {lower:g} is above its upper limit {upper:g} {place}",
                "no position satisfies both; the file is refused",
                "exchange lower and upper",
                "empty-range",
            )
        )
    elif lower == upper:
        findings.append(
            Finding(
                "warning",
                joint.name,
                f"its range is the single value {lower:g} {place}",
                "it cannot move, so tasks that need it conflict with its limits",
                f"make it fixed, or weld it: fixed_joints = ['{joint.name}']",
                "empty-range",
            )
        )
    elif joint.type == "revolute" and max(abs(lower), abs(upper)) > DEGREES:
        findings.append(
            Finding(
                "warning",
                joint.name,
                f"its range is {lower:g} to {upper:g} rad {place}, which looks like degrees",
                "the joint is free to turn as far as it states",
                f"state radians: lower={math.radians(lower):.3f} upper={math.radians(upper):.3f}",
                "degrees",
            )
        )
    mimic = joint.element.find("mimic")
    if mimic is not None:
        findings.append(
            Finding(
                "note",
                joint.name,
                f"mimics '{mimic.get('joint', '')}' {place}",
                "one motor moves both, which share its torque",
                f"weld it if it does not matter: fixed_joints = ['{joint.name}']",
                "mimic",
            )
        )
    return findings


def _placeholder_efforts(urdf: Urdf) -> list[Finding]:
    efforts = []
    for joint in urdf.joints:
        if joint.type in ("revolute", "continuous"):
            try:
                efforts.append(urdf.numbers(joint.element.find("limit"), "effort", (0.0,))[0])
            except RobotDescriptionError:
                return []
    if len(set(efforts)) == 1 and efforts[0] >= PLACEHOLDER_EFFORT:
        return [
            Finding(
                "warning",
                urdf.path.name,
                f"every joint states the effort limit {efforts[0]:g} N·m",
                "it looks like a placeholder, so torques are not limited",
                "state the motors' peaks, or effort_limits in a data file",
                "placeholder-effort-limit",
            )
        ]
    return []
