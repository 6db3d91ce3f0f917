"""References of the hands: leading them to positions or along paths in the standing frame."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wbc.motions.engine.motion_reference import FrameTarget
from wbc.motions.engine.reference import Path, SmoothReference
from wbc.robot.upper_body import Arm, Side, UpperBody
from wbc.tasks import PositionTask
from wbc.walking import Walker

_WEIGHT, _KP = 20.0, 120.0
_WORLD_WEIGHT = 100.0  # of a hand that is held in the world, against the sway of a gait
_ORIGIN, _AXES = np.zeros(3), np.eye(3)
_MAX_ERROR = 0.05  # m: a task that asks for more would make the CoM pay for it
_ENGAGE_TIME = 0.4  # s within which the task reaches its full weight
# Share of the posture's weight that is left to joints which other tasks lead.
_LED_ARM, _LED_WAIST = 0.1, 0.03


class HandReference:
    """Leads one hand in the standing frame, with a task whose weight changes smoothly.

    Args:
        walker: the walker whose controller gets the task.
        arm: the arm of the hand.

    Attributes:
        arm: the arm of the hand.
        place: (3,) reference position, m; standing frame, or world.
        error: distance of the hand from it at the last tick, m.
        in_world: whether the reference is in the world rather than in the standing frame.
    """

    def __init__(self, walker: Walker, arm: Arm) -> None:
        self.arm = arm
        self.place = SmoothReference(np.zeros(3), speed=1.0, acceleration=4.0)
        self._controller = walker.controller
        self._task = PositionTask(arm.hand, weight=0.0, kp=_KP, name=f"{arm.side} hand")
        self._task.target = np.zeros(3)
        self._task.bind(walker.robot)
        self._share = SmoothReference(0.0, speed=10.0, acceleration=100.0)
        self._number = 0
        self._is_target = False
        self.in_world = False
        self.error = 0.0

    def reset(self) -> None:
        """Release the hand at once."""
        self.place.reset()
        self._share.reset()
        self._number = 0
        self._is_target = self.in_world = False
        self._disengage()

    @property
    def share(self) -> float:
        """Share of the task's full weight: 0 leaves the hand to the posture, 1 leads it."""
        return float(self._share.value[0]) if self.engaged else 0.0

    @property
    def engaged(self) -> bool:
        """Whether the hand is led, or still being released."""
        return self._task in self._controller.tasks

    @property
    def target(self) -> FrameTarget | None:
        """The target that the hand has been brought to and is held at; None if there is none."""
        if not (self._is_target and self.place.arrived):
            return None
        return FrameTarget(self.arm.hand, self.place.value, self._number)

    def move_to(
        self, place: np.ndarray, now: np.ndarray, duration: float, *, is_target: bool
    ) -> None:
        """Lead the hand to a position.

        Args:
            place: (3,) standing frame, m.
            now: (3,) where the hand is, in case it has not been led so far, m.
            duration: s, at least.
            is_target: whether the position is a target that evaluators compare with.
        """
        self._engage(now)
        if self.in_world:
            self.in_world = False
            self.place.start_from(now, np.zeros(3))
        self.place.move_to(place, duration)
        self._is_target = is_target
        self._number += is_target

    def hold_in_world(self, now: np.ndarray) -> None:
        """Hold the hand where it is in the world, (3,) m, from now on."""
        self._engage(now)
        self.place.start_from(now, np.zeros(3))
        self._is_target, self.in_world = False, True

    def follow(self, path: Path, now: np.ndarray) -> None:
        """Lead the hand along a path.

        Args:
            path: time, s -> (3,) standing frame, m.
            now: (3,) where the hand is, in case it has not been led so far, m.
        """
        self._engage(now)
        if self.in_world:
            self.in_world = False
            self.place.start_from(now, np.zeros(3))
        self._is_target = False
        self.place.follow(path)

    def _engage(self, now: np.ndarray) -> None:
        if not self.engaged:
            self._controller.add(self._task)
            self.place.start_from(now, np.zeros(3))
        self._share.move_to(1.0, _ENGAGE_TIME)

    def hold(self) -> None:
        """Come to rest at the present reference."""
        self.place.move_to(self.place.value, 0.3)

    def release(self, duration: float = 0.5) -> None:
        """Leave the hand to the posture again, within a time, s."""
        self._is_target = False
        if self.engaged:
            self._share.move_to(0.0, duration)

    def advance(self, dt: float, origin: np.ndarray, axes: np.ndarray, now: np.ndarray) -> None:
        """Advance by a tick, and set the task.

        Args:
            dt: control period, s.
            origin: (3,) of the standing frame in the world, m.
            axes: (3, 3) of the standing frame in the world.
            now: (3,) where the hand is in the world, m.
        """
        if not self.engaged:
            return
        self._share.advance(dt)
        self.place.advance(dt)
        share = float(self._share.value[0])
        if share <= 0.0 and self._share.arrived:
            self._disengage()
            return
        task = self._task
        task.weight = (_WORLD_WEIGHT if self.in_world else _WEIGHT) * max(share, 0.0)
        if self.in_world:
            origin, axes = _ORIGIN, _AXES
        place = origin + axes @ self.place.value
        error = place - now
        self.error = distance = math.sqrt(float(error @ error))
        task.target = place if distance < _MAX_ERROR else now + (_MAX_ERROR / distance) * error
        task.velocity = axes @ self.place.velocity
        task.acceleration = axes @ self.place.acceleration

    def _disengage(self) -> None:
        if self.engaged:
            self._controller.remove(self._task)


class HandReferences:
    """Leads the hands, and reduces the posture's weight on the joints that they move.

    Args:
        walker: the walker, which balances.
        upper_body: arms and waist of its robot.
    """

    def __init__(self, walker: Walker, upper_body: UpperBody) -> None:
        self._walker, self._upper_body = walker, upper_body
        self._hands: dict[Side, HandReference] = {
            arm.side: HandReference(walker, arm) for arm in upper_body.arms
        }
        # What trunk and hands are led to must not fight with the posture: the CoM would pay.
        self._weights = walker.posture.weight.copy()
        self._weights[list(upper_body.waist)] *= _LED_WAIST
        walker.posture.weight = self._weights
        self._shares: tuple[float, ...] = ()

    def reset(self) -> None:
        """Release both hands at once."""
        for hand in self._hands.values():
            hand.reset()

    @property
    def sides(self) -> tuple[Side, ...]:
        """The sides that have a hand."""
        return tuple(self._hands)

    @property
    def engaged(self) -> bool:
        """Whether a hand is led, or still being released."""
        return any(hand.engaged for hand in self._hands.values())

    @property
    def targets(self) -> tuple[FrameTarget, ...]:
        """The targets that hands are held at now."""
        targets = (hand.target for hand in self._hands.values())
        return tuple(target for target in targets if target is not None)

    def reach(
        self,
        side: str,
        place: Sequence[float] | np.ndarray,
        duration: float = 1.0,
        *,
        is_target: bool = False,
    ) -> None:
        """Lead a hand to a position in the standing frame; `release` lets go of it.

        Args:
            side: "left" or "right".
            place: (3,) position of the hand's frame, m.
            duration: s, at least.
            is_target: whether the position, once reached, is a target that evaluators compare
                with.

        Raises:
            MotionError: the robot has no such arm.
        """
        hand = self._hand(side)
        place = np.asarray(place, dtype=float)
        hand.move_to(place, self.position(side), duration, is_target=is_target)

    def follow(self, side: str, path: Path) -> None:
        """Lead a hand along a path: time, s -> (3,) position in the standing frame, m.

        Raises:
            MotionError: the robot has no such arm.
        """
        self._hand(side).follow(path, self.position(side))

    def hold_in_world(self, side: str) -> None:
        """Hold a hand at its present place in the world, wherever the robot steps.

        Raises:
            MotionError: the robot has no such arm.
        """
        hand = self._hand(side)
        hand.hold_in_world(self._walker.kinematics.frame(hand.arm.hand).translation.copy())

    def error(self, side: str) -> float:
        """Return the distance of a hand that is led from its reference at the last tick, m."""
        return self._hand(side).error

    def release(self, duration: float = 0.5, side: str | None = None) -> None:
        """Leave a hand, or both, to the posture again.

        Args:
            duration: s.
            side: "left" or "right"; None for both.

        Raises:
            MotionError: the robot has no such arm.
        """
        for hand in self._hands.values() if side is None else (self._hand(side),):
            hand.release(duration)

    def hold(self) -> None:
        """Bring both hands to rest at their present references."""
        for hand in self._hands.values():
            hand.hold()

    def _hand(self, side: str) -> HandReference:
        return self._hands[self._upper_body.arm(side).side]

    def position(self, side: str) -> np.ndarray:
        """Return the (3,) position of a hand's frame at the last tick, standing frame, m.

        Raises:
            MotionError: the robot has no such arm.
        """
        hand, frame = self._hand(side), self._walker.standing_frame
        return np.asarray(frame.actInv(self._walker.kinematics.frame(hand.arm.hand).translation))

    def advance(self, dt: float) -> None:
        """Advance by a tick, s; set tasks and the posture's weight."""
        if self.engaged:
            frame, kin = self._walker.standing_frame, self._walker.kinematics
            for hand in self._hands.values():
                now = kin.frame(hand.arm.hand).translation
                hand.advance(dt, frame.translation, frame.rotation, now)
        shares = tuple(hand.share for hand in self._hands.values())
        if shares != self._shares:
            self._shares = shares
            weights = self._weights.copy()
            for hand in self._hands.values():
                weights[list(hand.arm.joints)] *= 1.0 - (1.0 - _LED_ARM) * hand.share
            self._walker.posture.weight = weights
