"""Squat: the centre of mass down and up, over both feet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import MAX_TORQUE_SHARE, holding_effort, pelvis_violation
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

_MAX_COM_ERROR = 1e-3  # m
_SAMPLES = 7  # postures along the way down
_DEGREE = 4  # of the polynomial through them


@dataclass(frozen=True)
class Squat(Motion):
    """Move the CoM down and up along a cosine, never above standing, so that no knee locks."""

    name: ClassVar[str] = "squat"
    summary: ClassVar[str] = "go down by a share of the leg's length, and up"

    depth: float = parameter(10.0, "descent of the CoM, % of the leg's length")
    frequency: float = parameter(0.5, "frequency of the squats, Hz")
    times: int = parameter(4, "number of squats")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "depth", "frequency", "times")
        ik = PostureIK(robot)
        self._joint_polynomials(robot)
        why = self._obstacle(ik, self.depth)
        if not why:
            return
        low, high = 0.0, self.depth
        while high - low > 0.1:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._obstacle(ik, middle) else (middle, high)
        raise MotionError(
            f"squat: {robot.name} cannot go down by {self.depth:g} % of its leg: {why}, and "
            f"{max(low, 0.1):.1f} % is the most"
        )

    @once_per_robot
    def _joint_polynomials(self, robot: Robot) -> np.ndarray:
        """Return (k, na) coefficients, highest power first, of the joints' way over the depth."""
        ik = PostureIK(robot)
        shares = np.linspace(0.0, 1.0, _SAMPLES)
        postures = [self._posture(ik, self.depth * share).q[7:] for share in shares]
        return np.asarray(np.polyfit(shares, np.array(postures) - postures[0], _DEGREE))

    def _posture(self, ik: PostureIK, depth: float) -> PostureSolution:
        down = np.array([0.0, 0.0, -0.01 * depth * ik.robot.leg_length])
        return ik.solve(PostureObjective(com=down, strict_trunk=True, strict_com=True))

    def _obstacle(self, ik: PostureIK, depth: float) -> str:
        """Return what keeps the robot from a depth (%); empty if nothing does."""
        robot, posture = ik.robot, self._posture(ik, depth)
        if posture.com_error > _MAX_COM_ERROR:
            return ik.limiting_joints(posture)
        if violation := pelvis_violation(robot, posture.q):
            return violation
        effort = holding_effort(robot, posture.q)
        # At the bottom the weight and the upward acceleration add up.
        amplitude = 0.005 * depth * robot.leg_length
        load = 1.0 + amplitude * (2.0 * math.pi * self.frequency) ** 2 / robot.gravity
        if effort.ratio * load > MAX_TORQUE_SHARE:
            return (
                f"'{effort.joint}' would need {100.0 * effort.ratio * load:.0f} % of its torque "
                f"(at most {100.0 * MAX_TORQUE_SHARE:.0f} %)"
            )
        return ""

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        depth = 0.01 * self.depth * context.robot.leg_length
        coefficients = self._joint_polynomials(context.robot)
        home = context.posture.home

        def share(time: float) -> float:
            return 0.5 * (1.0 - math.cos(2.0 * math.pi * self.frequency * time))

        def joints(time: float) -> np.ndarray:
            s = share(time)
            offset = coefficients[0]
            for coefficient in coefficients[1:]:
                offset = offset * s + coefficient
            return np.asarray(home + offset)

        context.com.follow(lambda t: np.array([0.0, 0.0, -depth * share(t)]))
        context.posture.follow(joints)
        yield from context.wait(self.times / self.frequency)
        context.com.move_to(0.0, 0.8)
        context.posture.move_to(home, 0.8)
        yield from context.until_arrived(context.com, context.posture)
