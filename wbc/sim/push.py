"""Pushes: external forces on a body for a while."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, slots=True)
class Push:
    """A constant force on one point of one body over some physics steps.

    Attributes:
        first: physics step at which the force sets in.
        end: first physics step without it.
        force: (3,) world axes, N.
        body: MuJoCo body id.
        point: (3,) where it acts, in the body's axes, m.
    """

    first: int
    end: int
    force: np.ndarray
    body: int
    point: np.ndarray


class Pushes:
    """The pushes of one run, applied as generalised forces."""

    def __init__(self, mujoco: Any, model: Any, data: Any) -> None:
        self._mujoco = mujoco
        self._model = model
        self._data = data
        self._pending: list[Push] = []
        self._none = np.zeros(3)

    def clear(self) -> None:
        """Forget all of them."""
        self._pending.clear()
        self._data.qfrc_applied[:] = 0.0

    def add(self, push: Push) -> None:
        """Schedule one; pushes that overlap add up."""
        self._pending.append(push)

    def apply(self, step: int) -> None:
        """Set the generalised force of this physics step; the kinematics must be fresh."""
        if not self._pending:
            return
        data = self._data
        data.qfrc_applied[:] = 0.0
        for push in self._pending:
            if push.first <= step < push.end:
                rotation = data.xmat[push.body].reshape(3, 3)
                point = data.xpos[push.body] + rotation @ push.point
                # Not xfrc_applied: that would show up in the foot sensors of a pushed foot.
                self._mujoco.mj_applyFT(
                    self._model,
                    data,
                    push.force,
                    self._none,
                    point,
                    push.body,
                    data.qfrc_applied,
                )
        self._pending = [p for p in self._pending if p.end > step]

    def force(self, step: int) -> np.ndarray:
        """(3,) sum of the forces that act at a physics step, world axes, N."""
        total = np.zeros(3)
        for push in self._pending:
            if push.first <= step < push.end:
                total += push.force
        return total
