"""References of the hands: leading them to positions or along paths in the standing frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from wbc.motions.engine.motion_reference import FrameTarget
from wbc.motions.engine.reference import Path, SmoothReference
from wbc.robot.upper_body import Arm, Side, UpperBody
from wbc.tasks import PositionTask
from wbc.walking import Walker

_WEIGHT, _KP = 20.0, 120.0
_WORLD_WEIGHT = 100.0  # of a hand that is led while the robot may walk, against the sway
_ORIGIN, _AXES = np.zeros(3), np.eye(3)
#: Frame of a hand's reference: the standing frame, the world, or the base frame, which has its
#: origin at the root link and the axes of the standing frame.
HandFrame = Literal["standing", "world", "base"]
_WEIGHTS: dict[HandFrame, float] = {
    "standing": _WEIGHT, "world": _WORLD_WEIGHT, "base": _WORLD_WEIGHT,
}  # fmt: skip
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
        place: (3,) reference position in its frame, m.
        frame: frame of the reference.
        error: distance of the hand from it at the last tick, m.
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
        self.frame: HandFrame = "standing"
        self.error = 0.0

    def reset(self) -> None:
        """Release the hand at once."""
        self.place.reset()
        self._share.reset()
        self._number = 0
        self._is_target = False
        self.frame = "standing"
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
        self,
        place: np.ndarray,
        now: np.ndarray,
        duration: float,
        *,
        is_target: bool,
        frame: HandFrame = "standing",
    ) -> None:
        """Lead the hand to a position.

        Args:
            place: (3,) m.
            now: (3,) where the hand is, in case it has not been led so far, m.
            duration: s, at least.
            is_target: whether the position is a target that evaluators compare with.
            frame: frame of both positions.
        """
        self._engage(now, frame)
        self.place.move_to(place, duration)
        self._is_target = is_target
        self._number += is_target

    def hold_in_world(self, now: np.ndarray) -> None:
        """Hold the hand where it is in the world, (3,) m, from now on."""
        self._engage(now, "world")
        self.place.start_from(now, np.zeros(3))
        self._is_target = False

    def follow(self, path: Path, now: np.ndarray) -> None:
        """Lead the hand along a path.

        Args:
            path: time, s -> (3,) standing frame, m.
            now: (3,) where the hand is, in case it has not been led so far, m.
        """
        self._engage(now, "standing")
        self._is_target = False
        self.place.follow(path)

    def _engage(self, now: np.ndarray, frame: HandFrame) -> None:
        if not self.engaged:
            self._controller.add(self._task)
        elif frame == self.frame:
            self._share.move_to(1.0, _ENGAGE_TIME)
            return
        self.frame = frame
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

    def advance(self, dt: float, walker: Walker, origin: np.ndarray, axes: np.ndarray) -> None:
        """Advance by a tick, and set the task.

        Args:
            dt: control period, s.
            walker: the walker, whose last tick tells where the hand is.
            origin: (3,) of the reference's frame in the world, m.
            axes: (3, 3) of it.
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
        task.weight = _WEIGHTS[self.frame] * max(share, 0.0)
        now = walker.kinematics.frame(self.arm.hand).translation
        place = origin + axes @ self.place.value
        error = place - now
        self.error = distance = math.sqrt(float(error @ error))
        task.target = place if distance < _MAX_ERROR else now + (_MAX_ERROR / distance) * error
        task.velocity = axes @ self.place.velocity
        if self.frame == "base":
            task.velocity += base_velocity(walker, place - origin)
        task.acceleration = axes @ self.place.acceleration

    def _disengage(self) -> None:
        if self.engaged:
            self._controller.remove(self._task)


def frame_of_hands(walker: Walker, frame: HandFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return origin (3,), m, and axes (3, 3) of a frame of hand references in the world."""
    if frame == "world":
        return _ORIGIN, _AXES
    standing = walker.standing_frame
    if frame == "standing":
        return standing.translation, standing.rotation
    return walker.kinematics.base.translation, standing.rotation


def turn_rate(walker: Walker) -> float:
    """Return the base's angular velocity about the vertical, rad/s."""
    kin = walker.kinematics
    return float(kin.base.rotation[2] @ kin.state.v[3:6])


def base_velocity(walker: Walker, lever: np.ndarray) -> np.ndarray:
    """Return the velocity (3,) of a point that turns and moves with the base frame, m/s.

    Args:
        walker: the walker.
        lever: (3,) from the base's origin to the point, world axes, m.
    """
    kin, turn = walker.kinematics, turn_rate(walker)
    velocity = kin.base.rotation @ kin.state.v[:3]
    return np.asarray(velocity + np.array([-turn * lever[1], turn * lever[0], 0.0]))


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
        self._left = np.ones_like(self._weights)  # share of them that is left to the posture
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
        frame: HandFrame = "standing",
    ) -> None:
        """Lead a hand to a position; `release` lets go of it.

        Args:
            side: "left" or "right".
            place: (3,) position of the hand's frame, m.
            duration: s, at least.
            is_target: whether the position, once reached, is a target that evaluators compare
                with.
            frame: frame of the position. A hand that is led in the base frame walks along, without
                the steps of the standing frame, which lies between the feet.

        Raises:
            MotionError: the robot has no such arm.
        """
        hand = self._hand(side)
        origin, axes = frame_of_hands(self._walker, frame)
        now = axes.T @ (self._walker.kinematics.frame(hand.arm.hand).translation - origin)
        place = np.asarray(place, dtype=float)
        hand.move_to(place, now, duration, is_target=is_target, frame=frame)

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
            frames = {
                frame: frame_of_hands(self._walker, frame)
                for frame in {hand.frame for hand in self._hands.values()}
            }
            for hand in self._hands.values():
                hand.advance(dt, self._walker, *frames[hand.frame])
        shares = tuple(hand.share for hand in self._hands.values())
        if shares != self._shares:
            self._shares = shares
            left = np.ones_like(self._left)
            for hand in self._hands.values():
                left[list(hand.arm.joints)] *= 1.0 - (1.0 - _LED_ARM) * hand.share
            posture = self._walker.posture
            if not np.array_equal(posture.weight, self._weights * self._left):  # set by others
                self._weights = posture.weight / self._left
            posture.weight, self._left = self._weights * left, left
