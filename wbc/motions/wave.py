"""Wave: both hands above the shoulders, from side to side; standing or walking."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective
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
from wbc.robot.upper_body import UpperBody

# Shares of the arm's length: position forward, outward and up from the shoulder; stroke.
# Nearer to the head, the elbows of a G1 touch its trunk; farther out, the arms of Romeo are slow.
_PLACE = np.array([0.3, 0.4, 0.45])
_LOWER = np.array([0.25, 0.4, 0.25])
_STROKE = 0.15
_TOLERANCE = 0.02  # m
_RAISE_TIME = 1.5  # s
_SPEED = 0.75  # share of the greatest speed


@dataclass(frozen=True)
class Wave(Motion):
    """Raise both hands above the shoulders and wave, mirrored; if asked, while walking."""

    name: ClassVar[str] = "wave"
    summary: ClassVar[str] = "wave with both arms, standing or walking"

    frequency: float = parameter(1.0, "frequency of the waving, Hz")
    seconds: float = parameter(5.0, "duration of the waving, s")
    walk: float = parameter(0.0, "forward velocity while waving, m/s")

    @property
    def while_walking(self) -> bool:
        """See `Motion.while_walking`; with a velocity of its own it begins and ends standing."""
        return self.walk == 0.0

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "frequency", "seconds")
        self._postures(robot)

    @once_per_robot
    def _postures(self, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
        """Return the posture with the hands up and the amplitude of the waving, (na,) rad each."""
        upper_body, ik = UpperBody.of(robot), PostureIK(robot)
        arms = upper_body.both_arms()
        moving = np.array([j for arm in arms for j in arm.joints])
        for place in (_PLACE, _LOWER):
            middle = {}
            for arm in arms:
                shoulder = ik.frame_position(arm.shoulder)
                outward = 1.0 if arm.side == "left" else -1.0
                middle[arm.hand] = shoulder + arm.length * place * [1.0, outward, 1.0]
            posture = ik.solve(PostureObjective(hands=middle, strict_trunk=True, strict_com=True))
            if max(posture.hand_errors.values()) < _TOLERANCE:
                break
        above = min(
            float(
                ik.frame_position(arm.hand, posture.q)[2]
                - ik.frame_position(arm.shoulder, posture.q)[2]
            )
            for arm in arms
        )
        if above <= 0.0:
            raise MotionError(f"wave: {robot.name} cannot bring both hands above its shoulders")
        ends = []
        for sign in (1.0, -1.0):
            hands = {}
            for arm in arms:
                outward = sign if arm.side == "left" else -sign
                stroke = np.array([0.0, outward * _STROKE * arm.length, 0.0])
                hands[arm.hand] = ik.frame_position(arm.hand, posture.q) + stroke
            objective = PostureObjective(hands=hands, strict_trunk=True, strict_com=True)
            ends.append(ik.solve(objective, posture.q, restarts=0).q[7:])
        up, swing = robot.q_nominal[7:].copy(), np.zeros(robot.na)
        up[moving] = 0.5 * (ends[0] + ends[1])[moving]
        swing[moving] = 0.5 * (ends[0] - ends[1])[moving]
        return up, swing

    def _speed(self, context: MotionContext) -> float:
        """Return the forward velocity, m/s, within what the gait allows with raised arms.

        Raised arms increase the inertia about the vertical, against which fast steps turn the
        trunk.
        """
        limit = _SPEED * context.walker.gait.max_velocity.forward
        if abs(self.walk) > limit:
            context.note(
                f"walks at {limit:.2f} m/s instead of {self.walk:g} m/s: with raised arms at "
                f"{100.0 * _SPEED:.0f} % of its fastest"
            )
        return max(-limit, min(limit, self.walk))

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        up, swing = self._postures(context.robot)
        if self.walk:
            context.feet.walk((self._speed(context), 0.0, 0.0))
        context.posture.move_to(up, _RAISE_TIME)
        yield from context.until_arrived(context.posture)
        rate = 2.0 * math.pi * self.frequency
        context.posture.follow(
            lambda t: up + math.sin(rate * t) * swing, blend=0.5 / self.frequency
        )
        yield from context.wait(self.seconds)
        context.posture.move_to(context.posture.home, _RAISE_TIME)
        if self.walk:
            context.feet.walk((0.0, 0.0, 0.0))
        yield from context.until_arrived(context.posture)
        if self.walk:
            yield from context.until(lambda: context.standing)
