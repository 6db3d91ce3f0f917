"""Leads hands to commanded positions while the robot stands or walks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wbc.motions import MotionPlayer
from wbc.motions.engine.hands import HandFrame, frame_of_hands
from wbc.runtime.schema import ODOM, XYZ, Quantity
from wbc.teleop.commands import HandTargetCommand

_REACH = 0.9  # share of the stretched arm's length, from the shoulder
_DURATION = 0.3  # s, at least, to a new target


class HandTargets:
    """Leads the hands of a motion player while it plays no motion.

    Args:
        player: the controller whose hands are led.
    """

    def __init__(self, player: MotionPlayer) -> None:
        self._player = player
        self._arms = {arm.side: arm for arm in player.context.upper_body.arms}
        self._waiting: dict[str, np.ndarray] = {}  # (3,) world axes, m, until it is idle
        self._targets: dict[str, tuple[np.ndarray, HandFrame]] = {}  # (3,) m, in this frame

    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities of a tick that tell the targets."""
        return tuple(
            Quantity(
                f"{side}_hand_target",
                lambda _, side=side: self.position(side),  # type: ignore[misc]
                f"commanded position of the {side} hand",
                "m",
                3,
                XYZ,
                ODOM,
                "point",
            )
            for side in self._arms
        )

    def set(self, command: HandTargetCommand) -> str:
        """Take a command; return why it is refused, or an empty text."""
        player, side = self._player, command.side
        self._waiting.pop(side, None)
        if command.position is None:
            if self._targets.pop(side, None) is not None:
                player.context.hands.release(_DURATION, side)
            return ""
        if player.playing is not None:
            return "a motion is playing, which leads the hands"
        if not player.idle:  # it returns to standing
            self._waiting[side] = np.array(command.position)
            return ""
        self._lead(side, self._within_reach(side, np.array(command.position)))
        return ""

    def _lead(self, side: str, position: np.ndarray) -> None:
        """Lead a hand to a position (3,), world axes, m, in the frame of what the robot does."""
        walker, frame = self._player.walker, self._frame
        origin, axes = frame_of_hands(walker, frame)
        self._targets[side] = axes.T @ (position - origin), frame
        self._player.context.hands.reach(side, self._targets[side][0], _DURATION, frame=frame)

    @property
    def _frame(self) -> HandFrame:
        """A frame that moves smoothly: the standing frame steps with the feet, the base sways."""
        return "standing" if self._player.context.stance.at_rest else "base"

    def _within_reach(self, side: str, position: np.ndarray) -> np.ndarray:
        """Return the nearest position (3,) that the arm reaches, world axes, m."""
        arm = self._arms[side]  # type: ignore[index]
        shoulder = self._player.walker.kinematics.frame(arm.shoulder).translation
        way = position - shoulder
        share = _REACH * arm.length / max(math.sqrt(float(way @ way)), 1e-9)
        return np.asarray(shoulder + min(share, 1.0) * way)

    def position(self, side: str) -> Any:
        """Return the (3,) target of a hand, world axes, m; NaN without one."""
        if side not in self._targets:
            return math.nan
        place, frame = self._targets[side]
        origin, axes = frame_of_hands(self._player.walker, frame)
        return origin + axes @ place

    def advance(self) -> None:
        """Change the frames when the robot begins to walk, or stands; call it before each tick.

        When a motion leads the hands, or leads them home, the targets are forgotten.
        """
        if not (self._targets or self._waiting):
            return
        if not self._player.idle:
            self._targets.clear()
            if self._player.playing is not None:
                self._waiting.clear()
            return
        for side, position in self._waiting.items():
            self._lead(side, self._within_reach(side, position))
        self._waiting.clear()
        frame = self._frame
        for side, (_, before) in tuple(self._targets.items()):
            if frame != before:
                self._lead(side, self.position(side))

    def stand(self) -> None:
        """Forget the targets that wait: the robot is to stand. The others end as it moves home."""
        self._waiting.clear()

    def clear(self) -> None:
        """Forget all targets: a run begins."""
        self._targets.clear()
        self._waiting.clear()
