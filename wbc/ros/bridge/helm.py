"""What the loop does with orders: between two ticks, and without waiting."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from wbc.loop import StopRun
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.walking import Walker

STANDING = (0.0, 0.0, 0.0)
_SHARE = 0.5  # of the joints' speed limits


class Helm:
    """Steers a walker by the orders in a mailbox; `wbc.run` calls it before each tick.

    A velocity ends by itself when nobody renews it, be it that a client went silent or that
    the node's process died.

    Args:
        mailbox: of the orders.
        walker: whom to steer.
        plant: which may have `push` and `reset`.

    Attributes:
        reset_wanted: a reset was asked for, and the run ended for it.
    """

    def __init__(self, mailbox: Mailbox, walker: Walker, plant: Any) -> None:
        self._mailbox, self._walker, self._plant = mailbox, walker, plant
        self._velocity = STANDING
        self._pushes = self._resets = 0
        robot = walker.robot
        self._slowest = _SHARE * np.minimum(robot.v_max, 1e3) * walker.dt
        self._orders: Orders | None = None
        self._moving = self._begun = False
        self.reset_wanted = False

    def __call__(self, _: float) -> None:
        """Take the latest orders.

        Raises:
            StopRun: a reset is wanted.
        """
        if not self._begun:
            self._begun = True  # a run cannot be ended before its first tick
            return
        orders = self._mailbox.look()
        now = time.monotonic()
        velocity = orders.velocity if now < orders.velocity_until else STANDING
        if velocity != self._velocity:
            self._velocity = self._walker.velocity = velocity
        if orders is not self._orders:
            self._orders = orders
            self._moving = True
            self._take(orders)
        if self._moving:
            self._move_joints(orders, now)

    def begin(self) -> None:
        """A run begins: what was asked for before it is forgotten."""
        orders = self._mailbox.look()
        self._orders, self._moving = orders, False
        self._pushes, self._resets = orders.pushes, orders.resets
        self._velocity = self._walker.velocity = STANDING
        self.reset_wanted = self._begun = False

    @property
    def reset_asked(self) -> bool:
        """Whether a reset has been asked for since the run began."""
        return self._mailbox.look().resets != self._resets

    def _take(self, orders: Orders) -> None:
        if orders.pushes != self._pushes:
            self._pushes = orders.pushes
            self._plant.push(np.array(orders.impulse), duration=orders.push_duration)
        if orders.resets != self._resets:
            self.reset_wanted = True
            raise StopRun("reset")

    def _move_joints(self, orders: Orders, now: float) -> None:
        """Lead the posture's target to where it is wanted, never faster than it may go."""
        target = self._walker.posture.target
        missing = orders.joints - target
        missing[np.isnan(missing)] = 0.0
        dt = self._walker.dt
        step = missing * (dt / max(orders.arrival - now, dt))
        most = np.minimum(self._slowest, orders.joint_speed * dt)
        target += np.clip(step, -most, most)
        self._moving = bool(np.abs(missing).max() > 1e-9)
