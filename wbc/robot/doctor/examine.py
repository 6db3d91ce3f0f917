"""The checks of a robot description, put together: defects, their consequences and their cures.

A file that cannot be loaded is checked as far as possible from its XML alone.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pinocchio as pin

from wbc.errors import RobotDescriptionError, RobotNotFound
from wbc.robot.data_file import RobotData
from wbc.robot.description import read_description
from wbc.robot.doctor.geometry import check_meshes, check_shapes
from wbc.robot.doctor.limits import check_limits
from wbc.robot.doctor.links import check_links, check_masses
from wbc.robot.doctor.stance import check_stance
from wbc.robot.doctor.tree import check_tree
from wbc.robot.finding import SEVERITIES, Finding
from wbc.robot.inertia import massless_joints
from wbc.robot.loader import build_robot, feet_links
from wbc.robot.model import build_model
from wbc.robot.packages import search_folders
from wbc.robot.registry import find_robot
from wbc.robot.urdf import Urdf

if TYPE_CHECKING:
    from wbc.robot.robot import Robot

# The loader reports these itself: it knows what a data file states and what was substituted.
REPORTED_BY_LOADER = ("no-effort-limit", "no-velocity-limit")


def check_file(path: str | Path, **stated: Any) -> list[Finding]:
    """Return all defects of a robot description, the worst first; none if it is sound.

    Args:
        path: a URDF, a robot data file, or a robot's name, as for `load`.
        stated: what `load` takes besides (`left_foot`, `right_foot`, `package_dirs`, …).

    Raises:
        RobotNotFound: there is no such file.
    """
    try:
        data = find_robot(path).with_arguments(**stated)
        urdf = read_description(data.urdf)
    except RobotNotFound:
        raise
    except RobotDescriptionError as error:
        return [Finding.from_error(error, Path(path).name, "unreadable")]
    findings = _examine(urdf, search_folders(data.urdf, data.package_dirs))
    if not _broken(findings):
        findings += _feet_and_masses(data, urdf)
    if not _broken(findings):
        try:
            robot = build_robot(data)
        except RobotDescriptionError as error:
            findings.append(Finding.from_error(error, urdf.path.name, "unloadable"))
        else:
            return check_robot(robot)
    return _sorted(findings)


def check_robot(robot: Robot) -> list[Finding]:
    """Return all defects of a loaded robot's description, the worst first."""
    found = [
        f for f in _examine(robot.urdf, robot.package_dirs) if f.code not in REPORTED_BY_LOADER
    ]
    return _sorted([*robot.findings, *found, *check_stance(robot)])


def _examine(urdf: Urdf, folders: tuple[Path, ...]) -> list[Finding]:
    return [
        *check_tree(urdf),
        *check_links(urdf),
        *check_limits(urdf),
        *check_shapes(urdf),
        *check_meshes(urdf, folders),
    ]


def _feet_and_masses(data: RobotData, urdf: Urdf) -> list[Finding]:
    """Defects for which a sound tree is refused: massless joints and unknown feet."""
    try:
        model = build_model(urdf, data.fixed_joints)
    except RobotDescriptionError as error:
        return [Finding.from_error(error, urdf.path.name, "unloadable")]
    findings = check_masses(urdf, massless_joints(model, pin.neutral(model)))
    try:
        feet_links(data, urdf, model)
    except RobotDescriptionError as error:
        findings.append(Finding.from_error(error, urdf.path.name, "feet-not-found"))
    return findings


def _broken(findings: list[Finding]) -> bool:
    return any(finding.severity == "error" for finding in findings)


def _sorted(findings: list[Finding]) -> list[Finding]:
    """Sort by severity, and keep each kind of defect once per link or joint."""
    singular = {f.subject for f in findings if f.code == "singular-mass-matrix"}
    once: dict[tuple[str, str], Finding] = {}
    for finding in findings:
        # The error says more than the warning about the same missing inertia.
        if finding.code != "no-inertia" or finding.subject not in singular:
            once.setdefault((finding.code, finding.subject), finding)
    return sorted(once.values(), key=lambda finding: SEVERITIES.index(finding.severity))
