"""Batches of consecutive ticks with their kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.geometry.wrench import centre_of_pressure
from wbc.robot import Robot

_MIN_FORCE = 1e-3  # share of the weight below which a foot has no centre of pressure


@dataclass(frozen=True, eq=False)
class TickBatch:
    """Records of ticks in order of time.

    Attributes:
        records: Structured array, shape (n,), whose fields are the columns of the schema.
        stamps: Times of the messages, ns, shape (n,).
        soles: Pose of each sole by name, frame `odom`: position, m, and quaternion x y z w,
            shape (n, 7).
        com: Centre of mass, m, frame `odom`, shape (n, 3).
        cop: Measured centre of pressure of both feet, m, frame `odom`, shape (n, 3); NaN in
            flight.
    """

    records: np.ndarray
    stamps: np.ndarray
    soles: dict[str, np.ndarray]
    com: np.ndarray
    cop: np.ndarray

    def __len__(self) -> int:
        """Return the number of ticks."""
        return len(self.records)

    def select(self, ticks: np.ndarray) -> TickBatch:
        """Return the ticks with some indices."""
        if len(ticks) == len(self):
            return self
        return TickBatch(
            self.records[ticks],
            self.stamps[ticks],
            {name: poses[ticks] for name, poses in self.soles.items()},
            self.com[ticks],
            self.cop[ticks],
        )


class BatchMaker:
    """Makes batches of records, with stamps that stay continuous over resets.

    Args:
        robot: Robot of the ticks.
    """

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model
        self._data = robot.model.createData()
        self._soles = [(sole.name, int(sole.frame_id)) for sole in robot.soles]
        self._min_force = _MIN_FORCE * robot.weight
        self._offset = 0.0
        self._last: float | None = None
        self._step = 0.0

    def batch(self, records: np.ndarray, stamps: np.ndarray | None = None) -> TickBatch:
        """Return records with their kinematics.

        Args:
            records: Structured array of records, shape (n,).
            stamps: Times of the messages, ns, shape (n,); continuous plant time by default.
        """
        n = len(records)
        soles = {name: np.empty((n, 7)) for name, _ in self._soles}
        com, cop = records["com"].copy(), np.full((n, 3), np.nan)
        model, data = self._model, self._data
        wrenches = {name: records[f"foot_wrench/{name}"] for name, _ in self._soles}
        for k in range(n):
            pin.framesForwardKinematics(model, data, records["q"][k])
            if not np.isfinite(com[k]).all():
                com[k] = pin.centerOfMass(model, data, False)
            moment, force = np.zeros(3), 0.0
            for name, frame in self._soles:
                placement = data.oMf[frame]
                soles[name][k] = pin.SE3ToXYZQUAT(placement)
                wrench = wrenches[name][k]
                if wrench[2] > self._min_force:
                    point = centre_of_pressure(wrench, self._min_force)
                    moment += wrench[2] * placement.act(point)
                    force += wrench[2]
            if force > 0.0:
                cop[k] = moment / force
        if stamps is None:
            stamps = self._plant_stamps(records["time"])
        return TickBatch(records, stamps, soles, com, cop)

    def _plant_stamps(self, times: np.ndarray) -> np.ndarray:
        """Return the plant time, ns, made continuous over resets."""
        stamps = np.empty(len(times), np.int64)
        for k, time in enumerate(times.tolist()):
            if not math.isfinite(time):  # a plant that has diverged
                time = (self._last or 0.0) + self._step
            if self._last is not None and time < self._last:
                self._offset += self._last + self._step - time
            elif self._last is not None:
                self._step = time - self._last
            self._last = time
            stamps[k] = round(1e9 * max(time + self._offset, 0.0))
        return stamps
