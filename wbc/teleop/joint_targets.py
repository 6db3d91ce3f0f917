"""Moves the joints of arms, trunk and head to commanded positions."""

from __future__ import annotations

import numpy as np

from wbc.motions import MotionPlayer
from wbc.teleop.commands import JointCommand

SPEED_SHARE = 0.5  #: of a joint's speed limit, at which commands may move it
_ARRIVED = 1e-9  # rad


class JointTargets:
    """Moves the home posture of a motion player towards the commanded positions.

    The latest command holds for its joints; the others keep their targets.

    Args:
        player: the controller whose posture is moved.
    """

    def __init__(self, player: MotionPlayer) -> None:
        self._player = player
        robot = player.robot
        self._index = {name: i for i, name in enumerate(robot.joint_names)}
        self._speed_limit = SPEED_SHARE * np.minimum(robot.v_max, 1e3)
        self._targets = np.full(robot.na, np.nan)  # rad; NaN: none
        self._arrival = 0.0
        self._max_speed = 0.0
        self._moving = False

    def set(self, command: JointCommand, stamp: float) -> None:
        """Take a command that was sent at `stamp`, s by `time.monotonic`."""
        self._targets[[self._index[name] for name in command.joints]] = command.positions
        self._arrival = stamp + command.duration
        self._max_speed = command.max_speed
        self._moving = True

    def clear(self) -> None:
        """Forget all targets."""
        self._targets[:] = np.nan
        self._moving = False

    def advance(self, now: float) -> None:
        """Move by one tick, unless a motion is playing.

        Args:
            now: s by `time.monotonic`.
        """
        if not (self._moving and self._player.idle):
            return
        posture, dt = self._player.context.posture, self._player.dt
        error = self._targets - posture.home
        error[np.isnan(error)] = 0.0
        step = error * (dt / max(self._arrival - now, dt))
        max_step = dt * np.minimum(self._speed_limit, self._max_speed)
        posture.move_home(posture.home + np.clip(step, -max_step, max_step))
        self._moving = bool(np.abs(error).max() > _ARRIVED)
