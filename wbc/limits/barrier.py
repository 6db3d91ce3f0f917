"""Limits on a function of the configuration that must not become negative: control barriers."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.limit import Limit, LimitRows

_NEGLIGIBLE = 1e-6  # m or rad


@dataclass(frozen=True, slots=True, eq=False)
class BarrierRows:
    """What a `BarrierLimit` writes: functions h(q) that must stay positive.

    Before each tick h is infinite and J zero, so that rows that are not written do not constrain
    anything.

    Attributes:
        h: (m,) values, m or rad.
        J: (m, nv) `ḣ = J v`.
        bias: (m,) J̇ v, or less where only a bound of it is known.
    """

    h: np.ndarray
    J: np.ndarray
    bias: np.ndarray


class BarrierLimit(Limit):
    """Keeps functions of the configuration positive, h(q) ≥ 0, at both levels.

    At velocity level `J v ≥ −γ h` with γ = min(gain, 1/dt); at acceleration level the same
    for the second derivative, with a double pole at −gain,

        J v̇ + J̇ v ≥ −2 gain J v − gain² h

    (Ames et al., Control barrier functions: theory and applications, ECC 2019; Nguyen and
    Sreenath, Exponential control barrier functions, ACC 2016). Where h is negative already it
    is brought back, at most with the recovery velocity: a barrier that asks for more than the
    joints can give would leave the QP without a solution.

    A body that is pinched has rows on both sides that cannot hold together. Then the exact rows of
    all barriers give way as little as possible (least squares), before anything else does: the
    robot goes on, and the command or the step says which rows and by how much.

    A barrier of your own derives from this and writes its rows in `write_barrier`.

    Args:
        name: unique within a controller.
        size: largest number of rows.
        gain: how fast h may fall towards zero, 1/s.
        recovery: largest velocity with which a violation is corrected, m/s or rad/s.
        unit: unit of h.
        labels: one text per row.
        priority, weight: see `Limit`.

    Raises:
        LimitError: a gain or recovery that is not positive, or see `Limit`.
    """

    def __init__(
        self,
        name: str,
        size: int,
        *,
        gain: float = 20.0,
        recovery: float = 0.1,
        unit: str = "m",
        labels: Sequence[str] = (),
        priority: int = 0,
        weight: float = 1.0,
    ) -> None:
        super().__init__(
            name, size, unit=f"{unit}/s²", labels=labels, priority=priority, weight=weight
        )
        for what, value in (("gain", gain), ("recovery", recovery)):
            if not 0.0 < value < math.inf:
                raise LimitError(f"limit '{name}': {what} {value} must be positive and finite")
        self.gain = gain
        self.recovery = recovery

    @abstractmethod
    def write_barrier(self, kin: Kinematics, barrier: BarrierRows) -> None:
        """Write h, its Jacobian and its bias in the present state."""

    def write(self, kin: Kinematics, rows: LimitRows) -> None:
        """See `Limit.write`."""
        barrier = self._evaluate(kin, rows.A)
        rate = barrier.J @ kin.state.v
        gain = self.gain
        wanted = gain * np.maximum(barrier.h * gain, -self.recovery)
        rows.lower[:] = -2.0 * gain * rate - wanted - barrier.bias

    def write_velocity(self, kin: Kinematics, dt: float, rows: LimitRows) -> None:
        """See `Limit.write_velocity`."""
        barrier = self._evaluate(kin, rows.A)
        rate = min(self.gain, 1.0 / dt)
        rows.lower[:] = -np.maximum(rate * barrier.h, -self.recovery)

    def _evaluate(self, kin: Kinematics, A: np.ndarray) -> BarrierRows:
        barrier = BarrierRows(np.full(self.size, np.inf), A, np.zeros(self.size))
        self.write_barrier(kin, barrier)
        h = barrier.h
        # What rounding leaves is no violation: two rows could each ask for the other's opposite.
        np.copyto(h, np.minimum(h + _NEGLIGIBLE, 0.0), where=h < 0.0)
        return barrier
