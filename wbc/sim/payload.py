"""Payloads: masses that are fixed to a body of the robot during a run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import PlantError


@dataclass(frozen=True, slots=True)
class Payload:
    """A ball that is fixed to a body of the robot from one moment on.

    Attributes:
        at_time: s.
        mass: kg; 0 takes off what is fixed to the body.
        body: MuJoCo body id.
        point: (3,) centre in the body's axes, m.
        radius: m.
    """

    at_time: float
    mass: float
    body: int
    point: np.ndarray
    radius: float = 0.05

    def __post_init__(self) -> None:
        if not 0.0 <= self.mass < math.inf:
            raise PlantError(
                f"a payload of {self.mass} kg: the mass must be finite and not negative"
            )

    def attach(self, mujoco: Any, model: Any) -> None:
        """Add the ball's inertia to the body's."""
        body = self.body
        w, x, y, z = model.body_iquat[body].tolist()
        axes = pin.Quaternion(w, x, y, z).matrix()
        own = pin.Inertia(
            float(model.body_mass[body]),
            model.body_ipos[body].copy(),
            axes @ np.diag(model.body_inertia[body]) @ axes.T,
        )
        ball = pin.Inertia.FromSphere(self.mass, self.radius)
        total = own + pin.SE3(np.eye(3), self.point).act(ball)
        moments, principal = np.linalg.eigh(total.inertia)
        if np.linalg.det(principal) < 0.0:
            principal[:, 0] *= -1.0
        x, y, z, w = pin.Quaternion(principal).normalized().coeffs().tolist()
        model.body_mass[body] = total.mass
        model.body_ipos[body] = total.lever
        model.body_iquat[body] = [w, x, y, z]
        model.body_inertia[body] = moments
        mujoco.mj_setConst(model, mujoco.MjData(model))


class Payloads:
    """The payloads of one run, and the masses that the model had without them."""

    def __init__(self, model: Any) -> None:
        self._pending: list[Payload] = []
        self._attached = False
        self._original = [getattr(model, name).copy() for name in _FIELDS]

    def clear(self, mujoco: Any, model: Any) -> None:
        """Take all payloads off."""
        self._pending.clear()
        if self._attached:
            self._take_off(slice(None), mujoco, model)
            self._attached = False

    def _take_off(self, bodies: int | slice, mujoco: Any, model: Any) -> None:
        for name, values in zip(_FIELDS, self._original, strict=True):
            getattr(model, name)[bodies] = values[bodies]
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def add(self, payload: Payload) -> None:
        """Schedule a payload."""
        self._pending.append(payload)

    def update(self, time: float, mujoco: Any, model: Any) -> None:
        """Attach what is due; call it before a physics step."""
        if not self._pending:
            return
        due = [payload for payload in self._pending if payload.at_time <= time]
        for payload in due:
            if payload.mass > 0.0:
                payload.attach(mujoco, model)
            else:
                self._take_off(payload.body, mujoco, model)
            self._pending.remove(payload)
            self._attached = True


_FIELDS = ("body_mass", "body_ipos", "body_iquat", "body_inertia")
