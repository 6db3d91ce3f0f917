"""A hand that can be led to places."""

from __future__ import annotations

import math

import numpy as np

from wbc.motions.engine.motion_reference import Target
from wbc.motions.engine.reference import Path, SmoothReference
from wbc.robot.upper_body import Arm
from wbc.tasks import PositionTask
from wbc.walking import Walker

_WEIGHT, _KP = 20.0, 120.0
_FAR = 0.05  # m: a hand that is farther off asks for no more, or the CoM would pay for it
_TAKE = 0.4  # s within which a hand comes under control


class Hand:
    """Leads a hand in the standing frame, with a weight that comes and goes smoothly.

    Args:
        walker: whose controller gets the task.
        arm: the hand's.

    Attributes:
        arm: the hand's.
        place: (3,) where it is led, standing frame, m.
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
        self._held = False

    def reset(self) -> None:
        """Let go of it at once."""
        self.place.reset()
        self._share.reset()
        self._number = 0
        self._held = False
        self._drop()

    @property
    def share(self) -> float:
        """How much it is led: 0 not at all, 1 fully."""
        return float(self._share.value[0]) if self.engaged else 0.0

    @property
    def engaged(self) -> bool:
        """It is led, or still being let go."""
        return self._task in self._controller.tasks

    @property
    def target(self) -> Target | None:
        """The place that it has been brought to and is held at."""
        if not (self._held and self.place.arrived):
            return None
        return Target(self.arm.hand, self.place.value, self._number)

    def go(self, place: np.ndarray, now: np.ndarray, duration: float, *, counts: bool) -> None:
        """Lead it to a place.

        Args:
            place: (3,) standing frame, m.
            now: (3,) where it is, for the case that it has not been led so far.
            duration: s, at least.
            counts: whether it is a target to be judged by.
        """
        self._engage(now)
        self.place.go(place, duration)
        self._held = counts
        self._number += counts

    def follow(self, path: Path, now: np.ndarray) -> None:
        """Lead it along a path.

        Args:
            path: time, s -> (3,) standing frame, m.
            now: (3,) where it is, for the case that it has not been led so far.
        """
        self._engage(now)
        self._held = False
        self.place.follow(path)

    def _engage(self, now: np.ndarray) -> None:
        if not self.engaged:
            self._controller.add(self._task)
            self.place.start_from(now, np.zeros(3))
        self._share.go(1.0, _TAKE)

    def stay(self) -> None:
        """Come to rest where it is led now."""
        self.place.go(self.place.value, 0.3)

    def release(self, duration: float = 0.5) -> None:
        """Let the posture have it again."""
        self._held = False
        if self.engaged:
            self._share.go(0.0, duration)

    def advance(self, dt: float, origin: np.ndarray, axes: np.ndarray, now: np.ndarray) -> None:
        """One tick.

        Args:
            dt: s.
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
            self._drop()
            return
        task = self._task
        task.weight = _WEIGHT * max(share, 0.0)
        place = origin + axes @ self.place.value
        off = place - now
        distance = math.sqrt(float(off @ off))
        task.target = place if distance < _FAR else now + (_FAR / distance) * off
        task.velocity = axes @ self.place.velocity
        task.acceleration = axes @ self.place.acceleration

    def _drop(self) -> None:
        if self.engaged:
            self._controller.remove(self._task)
