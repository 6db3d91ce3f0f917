"""Squat: the centre of mass down and up, over both feet."""

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

_GRAVITY = 9.81
_STRENGTH = 0.85  # share of a joint's torque that a squat may take, by statics
_MISS = 1e-3  # m
_DEPTHS = 7  # postures along the way
_DEGREE = 4  # of the polynomial through them


@dataclass(frozen=True)
class Squat(Motion):
    """Down and up in a cosine; never higher than standing, so that no knee locks."""

    name: ClassVar[str] = "squat"
    summary: ClassVar[str] = "go down by a share of the leg's length, and up"

    depth: float = parameter(10.0, "of the CoM's way down, % of the leg's length")
    frequency: float = parameter(0.5, "squats per second, Hz")
    times: int = parameter(4, "how many")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "depth", "frequency", "times")
        ik = PostureIK(robot)
        self._bends(robot)
        why = self._hindrance(ik, self._pose(ik, robot, self.depth), self.depth)
        if not why:
            return
        low, high = 0.0, self.depth
        while high - low > 0.1:
            middle = 0.5 * (low + high)
            pose = self._pose(ik, robot, middle)
            low, high = (low, middle) if self._hindrance(ik, pose, middle) else (middle, high)
        raise MotionError(
            f"squat: {robot.name} cannot go down by {self.depth:g} % of its leg: {why}; "
            f"{max(low, 0.1):.1f} % is the most"
        )

    @once_per_robot
    def _bends(self, robot: Robot) -> np.ndarray:
        """(k, na) polynomial, highest power first: what the joints add at a share of the depth."""
        ik = PostureIK(robot)
        shares = np.linspace(0.0, 1.0, _DEPTHS)
        poses = [self._pose(ik, robot, self.depth * share).q[7:] for share in shares]
        return np.asarray(np.polyfit(shares, np.array(poses) - poses[0], _DEGREE))

    def _pose(self, ik: PostureIK, robot: Robot, depth: float) -> PostureSolution:
        down = np.array([0.0, 0.0, -0.01 * depth * robot.leg_length])
        return ik.solve(PostureObjective(com=down, strict_trunk=True, strict_com=True))

    def _hindrance(self, ik: PostureIK, pose: PostureSolution, depth: float) -> str:
        """What keeps the robot from going so deep; empty when nothing does."""
        robot = ik.robot
        if pose.com_error > _MISS:
            return ik.limiting_joints(pose)
        if low := pelvis_violation(robot, pose.q):
            return low
        lowest = holding_effort(robot, pose.q)
        amplitude = 0.005 * depth * robot.leg_length
        swing = 1.0 + amplitude * (2.0 * math.pi * self.frequency) ** 2 / _GRAVITY
        if lowest.ratio * swing > _STRENGTH:
            return (
                f"'{lowest.joint}' would need {100.0 * lowest.ratio * swing:.0f} % of its torque "
                f"(at most {100.0 * _STRENGTH:.0f} %)"
            )
        return ""

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        depth = 0.01 * self.depth * context.robot.leg_length
        fit = self._bends(context.robot)
        home = context.posture.home

        def share(time: float) -> float:
            return 0.5 * (1.0 - math.cos(2.0 * math.pi * self.frequency * time))

        def joints(time: float) -> np.ndarray:
            s = share(time)
            bent = fit[0]
            for coefficient in fit[1:]:
                bent = bent * s + coefficient
            return np.asarray(home + bent)

        context.com.follow(lambda t: np.array([0.0, 0.0, -depth * share(t)]))
        context.posture.follow(joints)
        yield from context.wait(self.times / self.frequency)
        context.com.move_to(0.0, 0.8)
        context.posture.move_to(home, 0.8)
        yield from context.until_arrived(context.com, context.posture)
