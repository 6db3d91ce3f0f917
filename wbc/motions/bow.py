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
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion, Script, check_positive, once_per_robot, parameter
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

_STRENGTH = 0.9
_MISS = 0.02  # rad, and m


@dataclass(frozen=True)
class Bow(Motion):
    """The upper trunk bows; waist and hips share the angle, the CoM stays over the feet."""

    name: ClassVar[str] = "bow"
    summary: ClassVar[str] = "bow with waist and hips"

    angle: float = parameter(30.0, "of the upper trunk, °")
    hold: float = parameter(1.0, "at the bottom, s")
    seconds: float = parameter(1.5, "of the way down, and up, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "angle", "seconds")
        pose = self._pose(robot)
        short = abs(math.degrees(pose.torso[1]) - self.angle) > math.degrees(_MISS)
        why = pelvis_violation(robot, pose.q)
        if not why and (short or pose.com_error > _MISS):
            why = PostureIK(robot).limiting_joints(pose)
        if why:
            raise MotionError(f"bow: {robot.name} cannot bow by {self.angle:g}°: {why}")
        need = holding_effort(robot, pose.q)
        if need.ratio > _STRENGTH:
            raise MotionError(
                f"bow: {robot.name} cannot bow by {self.angle:g}°: '{need.joint}' would need "
                f"{100.0 * need.ratio:.0f} % of its torque"
            )

    @once_per_robot
    def _pose(self, robot: Robot) -> PostureSolution:
        turn = np.array([0.0, math.radians(self.angle), 0.0])
        pelvis = UpperBody.of(robot).hips_share(turn)
        return PostureIK(robot).solve(
            PostureObjective(torso=turn, pelvis=pelvis, strict_trunk=True, strict_com=True)
        )

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.go_to_posture(self._pose(context.robot), self.seconds)
        yield from context.until_arrived(context.torso, context.posture)
        yield from context.wait(self.hold)
        yield from context.go_home(self.seconds)
