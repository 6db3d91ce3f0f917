"""HandReferences of motions: hands that are led to places or along paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.motions.engine.feet import FootReferences
from wbc.motions.engine.hand import Hand
from wbc.motions.engine.reference import Path
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody
from wbc.walking import Walker

# Share of the posture's weight that is left to joints which are led otherwise.
_LED_ARM, _LED_WAIST = 0.1, 0.03


class HandReferences(FootReferences):
    """Leads hands, and has the posture let go of the joints that are led.

    Args:
        walker: that balances and steps.

    Attributes:
        robot: the robot.
        upper_body: its arms, head and waist.
        hands: the hands by side.
    """

    def __init__(self, walker: Walker) -> None:
        super().__init__(walker)
        self.robot: Robot = walker.robot
        self.upper_body = UpperBody.of(walker.robot)
        self.hands = {arm.side: Hand(walker, arm) for arm in self.upper_body.arms}
        # What trunk and hands are led to must not fight with the posture: the CoM would pay.
        self._weights = walker.posture.weight.copy()
        self._weights[list(self.upper_body.waist)] *= _LED_WAIST
        walker.posture.weight = self._weights
        self._shares: tuple[float, ...] = ()

    def reach(
        self, side: str, place: Sequence[float] | np.ndarray, duration: float = 1.0, *, counts: bool
    ) -> None:
        """Lead a hand to a place in the standing frame, m; `hands[side].release()` lets go.

        Args:
            side: "left" or "right".
            place: (3,) of the hand's frame, m.
            duration: s, at least.
            counts: whether it is a target to be judged by once it has arrived.

        Raises:
            MotionError: there is no such arm.
        """
        hand = self.hands[self.upper_body.arm(side).side]
        now = self._whereabouts(hand)
        hand.go(np.asarray(place, dtype=float), now, duration, counts=counts)

    def lead(self, side: str, path: Path) -> None:
        """Lead a hand along a path: time, s -> (3,) place in the standing frame, m.

        Raises:
            MotionError: there is no such arm.
        """
        hand = self.hands[self.upper_body.arm(side).side]
        hand.follow(path, self._whereabouts(hand))

    def _whereabouts(self, hand: Hand) -> np.ndarray:
        frame = self.walker.standing_frame
        return np.asarray(frame.actInv(self.walker.kinematics.frame(hand.arm.hand).translation))

    def _place_hands(self) -> None:
        if any(hand.engaged for hand in self.hands.values()):
            frame = self.walker.standing_frame
            kin = self.walker.kinematics
            for hand in self.hands.values():
                now = kin.frame(hand.arm.hand).translation
                hand.advance(self.dt, frame.translation, frame.rotation, now)
        shares = tuple(hand.share for hand in self.hands.values())
        if shares != self._shares:
            self._shares = shares
            weights = self._weights.copy()
            for hand in self.hands.values():
                weights[list(hand.arm.joints)] *= 1.0 - (1.0 - _LED_ARM) * hand.share
            self.walker.posture.weight = weights
