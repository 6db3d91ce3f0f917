"""The model doctor: what is wrong with a robot description, and the cure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wbc.robot.finding import SEVERITIES, Finding

if TYPE_CHECKING:
    from wbc.robot.robot import Robot


def check_robot(robot: Robot) -> list[Finding]:
    """Findings about a loaded robot, worst first."""
    return sorted(robot.findings, key=lambda finding: SEVERITIES.index(finding.severity))
