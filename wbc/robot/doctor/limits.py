"""Do the joints state limits that a controller can work with?"""

from __future__ import annotations

from wbc.errors import RobotDescriptionError
from wbc.robot.finding import Finding
from wbc.robot.model import has_no_range
from wbc.robot.urdf import Urdf, UrdfJoint

# An effort of this size on every joint is a placeholder of some exporter's, N·m.
DUMMY_EFFORT = 900.0


def check_limits(urdf: Urdf) -> list[Finding]:
    """Limits that are absent, zero, empty or the wrong way round, and mimicking joints."""
    findings: list[Finding] = []
    for joint in urdf.joints:
        if joint.kind in ("revolute", "prismatic", "continuous"):
            try:
                findings += _limits(urdf, joint)
            except RobotDescriptionError as error:
                findings.append(Finding.from_error(error, joint.name, "unreadable-number"))
    return findings + _dummies(urdf)


def _limits(urdf: Urdf, joint: UrdfJoint) -> list[Finding]:
    limit = joint.element.find("limit")
    lower, upper, effort, velocity = (
        urdf.numbers(limit, key, (0.0,))[0] for key in ("lower", "upper", "effort", "velocity")
    )
    place = f"(line {urdf.line(joint.element)})"
    findings = []
    for value, what, unit, cure in (
        (effort, "effort", "its motor's strength is assumed", "effort"),
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
    if joint.kind == "continuous":
        return findings
    if has_no_range(joint):
        findings.append(
            Finding(
                "warning",
                joint.name,
                f"has no position limits {place}",
                "a range of one turn (π) each way is assumed, and nothing keeps it off its stops",
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
                "exchange them",
                "empty-range",
            )
        )
    elif lower == upper:
        findings.append(
            Finding(
                "warning",
                joint.name,
                f"its range is the single value {lower:g} {place}",
                "it cannot move, and a controller that asks it to finds no solution",
                f"make it fixed, or weld it: fixed_joints = ['{joint.name}']",
                "empty-range",
            )
        )
    mimic = joint.element.find("mimic")
    if mimic is not None:
        findings.append(
            Finding(
                "note",
                joint.name,
                f"mimics '{mimic.get('joint', '')}' {place}",
                "it is taken as a joint with a motor of its own",
                f"weld it if it does not matter: fixed_joints = ['{joint.name}']",
                "mimic",
            )
        )
    return findings


def _dummies(urdf: Urdf) -> list[Finding]:
    efforts = []
    for joint in urdf.joints:
        if joint.kind in ("revolute", "continuous"):
            try:
                efforts.append(urdf.numbers(joint.element.find("limit"), "effort", (0.0,))[0])
            except RobotDescriptionError:
                return []
    if len(set(efforts)) == 1 and efforts[0] >= DUMMY_EFFORT:
        return [
            Finding(
                "warning",
                urdf.path.name,
                f"every joint states the effort limit {efforts[0]:g} N·m",
                "it looks like a placeholder, so the torque limits limit nothing",
                "state the motors' peaks, or effort_limits in a data file",
                "dummy-effort-limit",
            )
        ]
    return []
