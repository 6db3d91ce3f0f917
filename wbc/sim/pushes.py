"""Pushes: external forces on a body for some time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.errors import PlantError

_NO_TORQUE = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Push:
    """A constant force on one point of one body over some physics steps.

    Attributes:
        first: physics step at which the force begins.
        end: first physics step without it.
        force: (3,) world axes, N.
        body: MuJoCo body id.
        point: (3,) point of application in the body's axes, m.
    """

    first: int
    end: int
    force: np.ndarray
    body: int
    point: np.ndarray

    @staticmethod
    def of_impulse(
        impulse: Any,
        at_time: float,
        duration: float,
        timestep: float,
        *,
        body: int,
        point: np.ndarray,
    ) -> Push:
        """Return the constant force that delivers an impulse exactly, F = impulse / duration.

        Args:
            impulse: (3,) world axes, N·s.
            at_time: time at which it begins, rounded to physics steps, s.
            duration: rounded to physics steps, at least one, s.
            timestep: time step of the physics, s.
            body: see `Push`.
            point: see `Push`.

        Raises:
            PlantError: the impulse is not finite or of wrong shape, or the duration not positive.
        """
        vector = np.asarray(impulse, dtype=float)
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise PlantError(f"a push needs a finite (3,) impulse in N·s, not {impulse!r}")
        if not (np.isfinite(duration) and duration > 0.0):
            raise PlantError(f"a push of {duration} s: the duration must be positive")
        first, steps = round(at_time / timestep), max(1, round(duration / timestep))
        return Push(first, first + steps, vector / (steps * timestep), body, point)

    def acts(self, step: int) -> bool:
        """Return whether the force acts in a physics step."""
        return self.first <= step < self.end


class PushSchedule:
    """The pushes of one run that have not ended yet, applied as generalised forces."""

    def __init__(self) -> None:
        self._pending: list[Push] = []

    def clear(self) -> None:
        """Remove all pushes."""
        self._pending.clear()

    def add(self, push: Push) -> None:
        """Schedule a push; pushes that overlap add up."""
        self._pending.append(push)

    def apply(self, step: int, mujoco: Any, model: Any, data: Any) -> None:
        """Set the generalised force of a physics step; the kinematics must be up to date."""
        if not self._pending:
            return
        data.qfrc_applied[:] = 0.0
        for push in self._pending:
            if push.acts(step):
                rotation = data.xmat[push.body].reshape(3, 3)
                point = data.xpos[push.body] + rotation @ push.point
                # Not xfrc_applied: that would show up in the foot sensors of a pushed foot.
                mujoco.mj_applyFT(
                    model, data, push.force, _NO_TORQUE, point, push.body, data.qfrc_applied
                )
        self._pending = [push for push in self._pending if push.end > step]

    def force(self, step: int) -> np.ndarray:
        """Return the sum of the forces that act in a physics step, (3,), world axes, N."""
        return sum((push.force for push in self._pending if push.acts(step)), np.zeros(3))
