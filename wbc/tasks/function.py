"""Tasks on a function of the configuration: the base of those that are no motion of one frame."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from wbc.kinematics import Kinematics
from wbc.tasks.task import Task


@dataclass(frozen=True, slots=True, eq=False)
class FunctionRows:
    """What a `FunctionTask` writes: a function y(q), its derivatives and its error.

    Attributes:
        J: (m, nv) `ẏ = J v`.
        bias: (m,) J̇ v.
        error: (m,) target minus y.
    """

    J: np.ndarray
    bias: np.ndarray
    error: np.ndarray


class FunctionTask(Task):
    """Tracks a function y(q) of the configuration, at both levels.

    In accelerations `J v̇ = ÿ_ref + kd (ẏ_ref − J v) + kp (y_ref − y) − J̇ v`, in velocities
    `J v = ẏ_ref + (kp/kd) (y_ref − y)`.

    A task of your own derives from this and writes its rows in `write_function`.

    Attributes:
        velocity: (m,) reference velocity ẏ_ref.
        acceleration: (m,) feed-forward ÿ_ref.

    Raises:
        TaskError: see `Task`.
    """

    def __init__(
        self,
        name: str,
        size: int,
        weight: float | np.ndarray,
        kp: float | np.ndarray,
        kd: float | np.ndarray | None,
        priority: int,
    ) -> None:
        super().__init__(name, size, weight, kp, kd, priority)
        self.velocity, self.acceleration = np.zeros(size), np.zeros(size)

    @abstractmethod
    def write_function(self, kin: Kinematics, rows: FunctionRows) -> None:
        """Write Jacobian, bias and error in the present state.

        Args:
            kin: kinematics of the present state, which at velocity level is at rest.
            rows: arrays to write to, those of the last call.
        """

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """See `Task.write`."""
        rows = FunctionRows(A, np.zeros(self.size), np.zeros(self.size))
        self.write_function(kin, rows)
        b[:] = self.acceleration + self.kd * (self.velocity - A @ kin.state.v)
        b += self.kp * rows.error - rows.bias

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """See `Task.write_velocity`."""
        self.write_function(kin, FunctionRows(J, np.zeros(self.size), error))
        velocity[:] = self.velocity
