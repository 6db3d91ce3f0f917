"""Wave: both hands above the shoulders, to and fro; standing or walking."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective
from wbc.ik.posture_ik import PostureIK
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion, Script, check_positive, once_per_robot, parameter
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

# Shares of the arm's length: forward, outward and up from the shoulder, and the way to and fro.
_PLACE = np.array([0.2, 0.35, 0.5])
_LOWER = np.array([0.25, 0.4, 0.25])
_TRAVEL = 0.15
_NEAR = 0.02  # m
_RAISE = 1.5  # s
_SPEED = 0.75  # share of the greatest speed


@dataclass(frozen=True)
class Wave(Motion):
    """Both hands go above the shoulders and wave, mirrored; perhaps while it walks."""

    name: ClassVar[str] = "wave"
    summary: ClassVar[str] = "wave with both arms, standing or walking"

    frequency: float = parameter(1.0, "waves per second, Hz")
    seconds: float = parameter(5.0, "of the waving, s")
    walk: float = parameter(0.0, "forward speed meanwhile, m/s")

    @property
    def while_walking(self) -> bool:
        """See `Motion.while_walking`; with a speed of its own it begins and ends standing."""
        return self.walk == 0.0

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "frequency", "seconds")
        self._postures(robot)

    @once_per_robot
    def _postures(self, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
        """(na,) with the hands up, and (na,) half of the way to and fro, rad."""
        upper_body, ik = UpperBody.of(robot), PostureIK(robot)
        arms = upper_body.both_arms()
        moving = np.array([j for arm in arms for j in arm.joints])
        for place in (_PLACE, _LOWER):
            middle = {}
            for arm in arms:
                shoulder = ik.frame_position(arm.shoulder)
                outward = 1.0 if arm.side == "left" else -1.0
                middle[arm.hand] = shoulder + arm.length * place * [1.0, outward, 1.0]
            pose = ik.solve(PostureObjective(hands=middle, strict_trunk=True, strict_com=True))
            if max(pose.hand_errors.values()) < _NEAR:
                break
        above = min(
            float(
                ik.frame_position(arm.hand, pose.q)[2] - ik.frame_position(arm.shoulder, pose.q)[2]
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
                travel = np.array([0.0, outward * _TRAVEL * arm.length, 0.0])
                hands[arm.hand] = ik.frame_position(arm.hand, pose.q) + travel
            objective = PostureObjective(hands=hands, strict_trunk=True, strict_com=True)
            ends.append(ik.solve(objective, pose.q, restarts=0).q[7:])
        up, swing = robot.q_nominal[7:].copy(), np.zeros(robot.na)
        up[moving] = 0.5 * (ends[0] + ends[1])[moving]
        swing[moving] = 0.5 * (ends[0] - ends[1])[moving]
        return up, swing

    def _speed(self, context: MotionContext) -> float:
        """Forward, m/s: raised arms make the body slow to turn, which the fastest steps need."""
        most = _SPEED * context.walker.gait.max_velocity[0]
        if abs(self.walk) > most:
            context.note(
                f"walks at {most:.2f} m/s instead of {self.walk:g} m/s: with raised arms at "
                f"{100.0 * _SPEED:.0f} % of its fastest"
            )
        return max(-most, min(most, self.walk))

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        up, swing = self._postures(context.robot)
        if self.walk:
            context.feet.walk((self._speed(context), 0.0, 0.0))
        context.posture.move_to(up, _RAISE)
        yield from context.until_arrived(context.posture)
        rate = 2.0 * math.pi * self.frequency
        context.posture.follow(
            lambda t: up + math.sin(rate * t) * swing, blend=0.5 / self.frequency
        )
        yield from context.wait(self.seconds)
        context.posture.move_to(context.posture.home, _RAISE)
        if self.walk:
            context.feet.walk((0.0, 0.0, 0.0))
        yield from context.until_arrived(context.posture)
        if self.walk:
            yield from context.until(lambda: context.standing)
