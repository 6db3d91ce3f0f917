"""Bow: the trunk forward, and upright again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import holding_effort, pelvis_violation
from wbc.ik.posture_ik import PostureIK
from wbc.motions.engine import (
    Motion,
    MotionContext,
    Script,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.robot import Robot

_MAX_TORQUE_SHARE = 0.9  # of any torque limit, at rest
_TOLERANCE = 0.02  # rad, and m


@dataclass(frozen=True)
class Bow(Motion):
    """Bow with the upper trunk; waist and hips share the angle, the CoM stays over the feet."""

    name: ClassVar[str] = "bow"
    summary: ClassVar[str] = "bow with waist and hips"

    angle: float = parameter(30.0, "pitch of the upper trunk, °")
    hold: float = parameter(1.0, "pause at the bottom, s")
    seconds: float = parameter(1.5, "duration of the way down, and of the way up, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "angle", "seconds")
        posture = self._posture(robot)
        error = abs(math.degrees(posture.torso[1]) - self.angle)
        why = pelvis_violation(robot, posture.q)
        if not why and (error > math.degrees(_TOLERANCE) or posture.com_error > _TOLERANCE):
            why = PostureIK(robot).limiting_joints(posture)
        effort = holding_effort(robot, posture.q)
        if not why and effort.ratio > _MAX_TORQUE_SHARE:
            why = f"'{effort.joint}' would need {100.0 * effort.ratio:.0f} % of its torque"
        if why:
            raise MotionError(f"bow: {robot.name} cannot bow by {self.angle:g}°: {why}")

    @once_per_robot
    def _posture(self, robot: Robot) -> PostureSolution:
        ik = PostureIK(robot)
        turn = np.array([0.0, math.radians(self.angle), 0.0])
        pelvis = ik.upper_body.hips_share(turn)
        return ik.solve(
            PostureObjective(torso=turn, pelvis=pelvis, strict_trunk=True, strict_com=True)
        )

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.go_to_posture(self._posture(context.robot), self.seconds)
        yield from context.until_arrived(context.torso, context.posture)
        yield from context.wait(self.hold)
        yield from context.go_home(self.seconds)
