"""Some ticks in a row, with what their messages need besides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.geometry.wrench import centre_of_pressure

if TYPE_CHECKING:
    from wbc.log.order import Order

_LEAST_FORCE = 1e-3  # share of the weight below which a foot has no centre of pressure


@dataclass(frozen=True, eq=False)
class Block:
    """Records of ticks in the order of time.

    Attributes:
        records: (n,) of `Layout.dtype`.
        names: of contacts, by the numbers in the records.
        stamps: (n,) times of the log, ns.
        soles: name -> (n, 7) pose in the world, position (m) and quaternion x y z w.
        com: (n, 3) centre of mass, m, world.
        cop: (n, 3) centre of pressure under both feet as measured, m, world; NaN in the air.
    """

    records: np.ndarray
    names: list[str]
    stamps: np.ndarray
    soles: dict[str, np.ndarray]
    com: np.ndarray
    cop: np.ndarray

    def __len__(self) -> int:
        """Number of ticks."""
        return len(self.records)


class Tracker:
    """Makes blocks of records; keeps the time that they are logged at.

    A time before the previous one's begins a new run; the log's time goes on.

    Args:
        order: who is logged.
    """

    def __init__(self, order: Order) -> None:
        self._model = order.model
        self._data = order.model.createData()
        self._soles = order.soles
        gravity = float(np.linalg.norm(order.model.gravity.linear))
        self._least = _LEAST_FORCE * float(pin.computeTotalMass(order.model)) * gravity
        self._offset = 0.0
        self._last: float | None = None
        self._step = 0.0

    def block(self, records: np.ndarray, names: list[str]) -> Block:
        """Records with their times and kinematics."""
        n = len(records)
        soles = {name: np.empty((n, 7)) for name, _ in self._soles}
        com, cop = records["com"].copy(), np.full((n, 3), np.nan)
        model, data = self._model, self._data
        for k in range(n):
            pin.framesForwardKinematics(model, data, records["q"][k])
            if not np.isfinite(com[k]).all():
                com[k] = pin.centerOfMass(model, data, False)
            pressed, force = np.zeros(3), 0.0
            for i, (name, frame) in enumerate(self._soles):
                placement = data.oMf[frame]
                soles[name][k] = pin.SE3ToXYZQUAT(placement)
                wrench = records["foot_wrenches"][k, 6 * i : 6 * i + 6]
                if wrench[2] > self._least:
                    pressed += wrench[2] * placement.act(centre_of_pressure(wrench, self._least))
                    force += wrench[2]
            if force > 0.0:
                cop[k] = pressed / force
        return Block(records, names, self._stamps(records["time"]), soles, com, cop)

    def _stamps(self, times: np.ndarray) -> np.ndarray:
        stamps = np.empty(len(times), np.int64)
        for k, time in enumerate(times.tolist()):
            if not math.isfinite(time):  # a plant that has lost itself: the log goes on
                time = self._last or 0.0
            if self._last is not None and time < self._last:
                self._offset += self._last + self._step - time
            elif self._last is not None:
                self._step = time - self._last
            self._last = time
            stamps[k] = round(1e9 * max(time + self._offset, 0.0))
        return stamps
