"""Hold hand: a hand stays at one place of the world while the robot walks."""

from __future__ import annotations

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

_PLACE = np.array([0.55, 0.1, -0.25])  # forward, outward and up of the shoulder, in arm lengths
_TOLERANCE = 0.02  # m
_RAISE_TIME = 1.5  # s
_LATERAL_SHARE = 0.5  # of the velocity forward


@dataclass(frozen=True)
class HoldHand(Motion):
    """Hold a hand at a fixed place of the world while the feet step back, forth and sideways.

    The hand's reference is in the world, not relative to the robot: the arm takes up what steps and
    sway do. A note tells the largest distance of the hand from its place, as estimated.
    """

    name: ClassVar[str] = "hold-hand"
    summary: ClassVar[str] = "hold a hand at one place of the world while walking about it"

    hand: str = parameter("left", "hand that stays", choices=("left", "right"))
    speed: float = parameter(0.06, "velocity to and fro, m/s; 0 to step in place")
    leg: float = parameter(1.6, "duration of walking one way, s")
    rounds: int = parameter(1, "number of rounds: back, forth, to the left, to the right")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "leg", "rounds")
        if not self.speed >= 0.0:
            raise MotionError(f"hold-hand: speed = {self.speed} m/s must not be negative")
        reach = self.speed * self.leg
        most = 0.3 * UpperBody.of(robot).arm(self.hand).length
        if reach > most:
            raise MotionError(
                f"hold-hand: {self.leg:g} s at {self.speed:g} m/s lead {100.0 * reach:.0f} cm "
                f"away from the hand: at most {100.0 * most:.0f} cm, by the length of the arm"
            )
        self._posture(robot)

    @once_per_robot
    def _posture(self, robot: Robot) -> np.ndarray:
        """Return joint positions (na,) with the hand in front of the robot, rad."""
        ik, arm = PostureIK(robot), UpperBody.of(robot).arm(self.hand)
        outward = 1.0 if self.hand == "left" else -1.0
        place = ik.frame_position(arm.shoulder) + arm.length * _PLACE * [1.0, outward, 1.0]
        objective = PostureObjective(hands={arm.hand: place}, strict_trunk=True, strict_com=True)
        posture = ik.solve(objective)
        if posture.hand_error > _TOLERANCE:
            raise MotionError(
                f"hold-hand: the {self.hand} hand of {robot.name} stays "
                f"{100.0 * posture.hand_error:.0f} cm short of its place"
            )
        return np.asarray(posture.q[7:])

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.posture.move_to(self._posture(context.robot), _RAISE_TIME)
        yield from context.until_arrived(context.posture)
        hands = context.hands
        hands.hold_in_world(self.hand)
        yield from context.wait(0.5)
        farthest = 0.0
        lateral = _LATERAL_SHARE * self.speed
        ways = ((-self.speed, 0.0), (self.speed, 0.0), (0.0, lateral), (0.0, -lateral))
        for forward, left in ways * self.rounds:
            if not self.speed:
                context.feet.step_in_place(4)
            else:
                context.feet.walk((forward, left, 0.0))
            end = context.time + self.leg
            while context.time < end:
                farthest = max(farthest, hands.error(self.hand))
                yield
        context.feet.walk((0.0, 0.0, 0.0))
        while not context.standing:
            farthest = max(farthest, hands.error(self.hand))
            yield
        context.note(f"{self.hand} hand within {1e3 * farthest:.0f} mm of its place while walking")
        hands.release(0.5, self.hand)
        context.posture.move_to(context.posture.home, _RAISE_TIME)
        yield from context.until_arrived(context.posture)
