"""Pushes and pulls: external forces on a body for some time."""

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


@dataclass(frozen=True, slots=True)
class Pull:
    """A spring with a damper between one point of one body and a fixed point.

        F = k (p* − p) − d ṗ,  |F| ≤ F_max

    Attributes:
        body: MuJoCo body id.
        point: (3,) point p in the body's axes, m.
        target: (3,) fixed point p* in world axes, m.
        stiffness: k, N/m.
        damping: d, N·s/m.
        max_force: F_max, N.
    """

    body: int
    point: np.ndarray
    target: np.ndarray
    stiffness: float
    damping: float
    max_force: float

    def force(self, mujoco: Any, model: Any, data: Any, point: np.ndarray) -> np.ndarray:
        """Return the force on the body, (3,), world axes, N.

        Args:
            mujoco: the module.
            model: MuJoCo's model.
            data: MuJoCo's data, whose kinematics are up to date.
            point: (3,) the attached point, world axes, m.
        """
        velocity = np.empty(6)  # about the body's centre, world axes: rotation first
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, self.body, velocity, 0)
        moved = velocity[3:] + np.cross(velocity[:3], point - data.xipos[self.body])
        force: np.ndarray = self.stiffness * (self.target - point) - self.damping * moved
        size = float(np.linalg.norm(force))
        return force * min(1.0, self.max_force / size) if size > 0.0 else force


class PushSchedule:
    """The pushes of one run that have not ended yet, and a pull, applied as generalised forces.

    Attributes:
        pull: the pull that acts; None for none.
    """

    def __init__(self) -> None:
        self._pending: list[Push] = []
        self._applied = False  # whether the generalised force is not zero
        self.pull: Pull | None = None

    def clear(self) -> None:
        """Remove all pushes and the pull."""
        self._pending.clear()
        self._applied, self.pull = False, None

    def add(self, push: Push) -> None:
        """Schedule a push; pushes that overlap add up."""
        self._pending.append(push)

    def apply(self, step: int, mujoco: Any, model: Any, data: Any) -> None:
        """Set the generalised force of a physics step; the kinematics must be up to date."""
        pull = self.pull
        if not self._pending and pull is None and not self._applied:
            return
        data.qfrc_applied[:] = 0.0
        self._applied = pull is not None
        if pull is not None:
            rotation = data.xmat[pull.body].reshape(3, 3)
            point = data.xpos[pull.body] + rotation @ pull.point
            force = pull.force(mujoco, model, data, point)
            mujoco.mj_applyFT(model, data, force, _NO_TORQUE, point, pull.body, data.qfrc_applied)
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
