"""What the loop does with orders: between two ticks, and without waiting."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from wbc.motions import MotionPlayer, unpack
from wbc.motions.engine.blob_buffer import BlobBuffer
from wbc.motions.engine.manager import ZERO_VELOCITY, MotionManager, MotionStatus
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.bridge.slip import Slip
from wbc.runtime.loop import StopRun

_SHARE = 0.5  # of the joints' speed limits


class Helm:
    """Steers a player by the orders in a mailbox; `wbc.run` calls it before each tick.

    A velocity ends by itself when nobody renews it, be it that a client went silent or that
    the node's process died. Joints wait until a motion is over.

    Args:
        mailbox: of the orders.
        player: whom to steer.
        plant: which may have `push` and `reset`.

    Attributes:
        manager: through which.
        shelf: where motions lie that are ordered.
        slip: tells why a motion was given up.
        motions: how many have been taken from there.
    """

    def __init__(self, mailbox: Mailbox, player: MotionPlayer, plant: Any) -> None:
        self._mailbox, self._performer, self._plant = mailbox, player, plant
        self.manager = MotionManager(player)
        self.shelf, self.slip = BlobBuffer(), Slip()
        self._push = getattr(plant, "push", None)
        self._velocity = ZERO_VELOCITY
        self._forgotten = 0.0  # the end of a velocity that was asked for in the run before
        self._pushes = self._resets = self._stands = 0
        self.motions = 0
        robot = player.robot
        self._slowest = _SHARE * np.minimum(robot.v_max, 1e3) * player.dt
        self._orders: Orders | None = None
        self._moving = self._begun = False

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
        lasts = now < orders.velocity_until and orders.velocity_until != self._forgotten
        velocity = orders.velocity if lasts else ZERO_VELOCITY
        if velocity != self._velocity:
            self._velocity = self.manager.velocity = velocity
        if orders is not self._orders:
            self._orders = orders
            self._moving = True
            self._take(orders)
        self._steer()
        if self._moving and self._performer.idle:
            self._move_joints(orders, now)

    def begin(self) -> None:
        """A run begins: what was asked for before it is forgotten."""
        orders = self._mailbox.look()
        self._orders, self._moving = orders, False
        self._forgotten = orders.velocity_until
        self._pushes, self._resets = orders.pushes, orders.resets
        self.motions, self._stands = orders.motions, orders.stands
        self._velocity = ZERO_VELOCITY
        self.manager.reset()
        self._begun = False

    @property
    def reset_wanted(self) -> bool:
        """Whether a reset has been asked for since the run began."""
        return self._mailbox.look().resets != self._resets

    @property
    def stage(self) -> MotionStatus:
        """What became of the last of the `motions`."""
        return self.manager.status

    def close(self) -> None:
        """Give up what is shared with the node."""
        self.shelf.close()
        self.slip.close()

    def _take(self, orders: Orders) -> None:
        if orders.pushes != self._pushes:
            self._pushes = orders.pushes
            self._plant.push(np.array(orders.impulse), duration=orders.push_duration)
        if orders.resets != self._resets:
            raise StopRun("reset")
        if orders.stands != self._stands:
            self._stands = orders.stands
            self.manager.stand()
        if orders.motions != self.motions:
            self.motions = orders.motions
            packed = self.shelf.read(orders.slot, orders.size)
            self.manager.play(unpack(packed, self._performer.robot))

    def _steer(self) -> None:
        manager, player = self.manager, self._performer
        before = manager.status
        manager.update()
        if manager.status is not before and player.context.notes:
            self.slip.write(self.motions, player.context.notes[-1])
        for impulse in player.pop_pushes():
            if self._push is not None:
                self._push(impulse)

    def _move_joints(self, orders: Orders, now: float) -> None:
        """Lead the posture to where it is wanted, never faster than it may go."""
        posture, dt = self._performer.context.posture, self._performer.dt
        missing = orders.joints - posture.home
        missing[np.isnan(missing)] = 0.0
        step = missing * (dt / max(orders.arrival - now, dt))
        most = np.minimum(self._slowest, orders.joint_speed * dt)
        posture.move_home(posture.home + np.clip(step, -most, most))
        self._moving = bool(np.abs(missing).max() > 1e-9)
