"""Batches of consecutive ticks with their kinematics."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import pinocchio as pin

from wbc.robot import Robot

_MIN_FORCE = 1e-3  # share of the weight below which a foot has no centre of pressure


@dataclass(frozen=True, eq=False)
class BatchKinematics:
    """Quantities that follow from the records of a batch, frame `odom`.

    Attributes:
        soles: Pose of each sole by name: position, m, and quaternion x y z w, shape (n, 7).
        com: Centre of mass, m, shape (n, 3).
        cop: Measured centre of pressure of both feet, m, shape (n, 3); NaN in flight.
        imu: Orientation of the IMU, quaternion x y z w, shape (n, 4).
    """

    soles: dict[str, np.ndarray]
    com: np.ndarray
    cop: np.ndarray
    imu: np.ndarray

    def select(self, ticks: np.ndarray) -> BatchKinematics:
        """Return those of the ticks with some indices."""
        soles = {name: poses[ticks] for name, poses in self.soles.items()}
        return BatchKinematics(soles, self.com[ticks], self.cop[ticks], self.imu[ticks])


class TickBatch:
    """Records of ticks in order of time.

    Args:
        records: Structured array, shape (n,), whose fields are the columns of the schema.
        stamps: Times of the messages, ns, shape (n,).
        kinematics: Returns the kinematics of the records; called when they are first used.

    Attributes:
        records: See above.
        stamps: See above.
    """

    def __init__(
        self, records: np.ndarray, stamps: np.ndarray, kinematics: Callable[[], BatchKinematics]
    ) -> None:
        self.records, self.stamps = records, stamps
        self._kinematics = kinematics

    def __len__(self) -> int:
        """Return the number of ticks."""
        return len(self.records)

    @cached_property
    def kinematics(self) -> BatchKinematics:
        """Poses of the soles, centre of mass and centre of pressure."""
        return self._kinematics()

    def select(self, ticks: np.ndarray) -> TickBatch:
        """Return the ticks with some indices."""
        return TickBatch(
            self.records[ticks], self.stamps[ticks], lambda: self.kinematics.select(ticks)
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
        self._imu = int(robot.frame_id(robot.imu))
        self._min_force = _MIN_FORCE * robot.weight
        self._offset = 0.0
        self._last: float | None = None
        self._step = 0.0

    def batch(self, records: np.ndarray, stamps: np.ndarray | None = None) -> TickBatch:
        """Return records with their stamps and kinematics.

        Args:
            records: Structured array of records, shape (n,).
            stamps: Times of the messages, ns, shape (n,); continuous plant time by default.
        """
        if stamps is None:
            stamps = self._plant_stamps(records["time"])
        return TickBatch(records, stamps, partial(self._kinematics, records))

    def _kinematics(self, records: np.ndarray) -> BatchKinematics:
        n, model, data = len(records), self._model, self._data
        com = records["com"].copy()
        unknown = ~np.isfinite(com).all(axis=1)
        poses, rotations = np.empty((len(self._soles), n, 7)), np.empty((len(self._soles), n, 3, 3))
        imu = np.empty((n, 4))
        for k, q in enumerate(records["q"]):
            pin.forwardKinematics(model, data, q)
            for i, (_, frame) in enumerate(self._soles):
                placement = pin.updateFramePlacement(model, data, frame)
                poses[i, k] = pin.SE3ToXYZQUATtuple(placement)
                rotations[i, k] = placement.rotation
            imu[k] = pin.SE3ToXYZQUATtuple(pin.updateFramePlacement(model, data, self._imu))[3:]
            if unknown[k]:
                com[k] = pin.centerOfMass(model, data, False)
        soles = {name: poses[i] for i, (name, _) in enumerate(self._soles)}
        wrenches = np.stack([records[f"foot_wrench/{name}"] for name in soles])
        cop = self._centre_of_pressure(poses[:, :, :3], rotations, wrenches)
        return BatchKinematics(soles, com, cop, imu)

    def _centre_of_pressure(
        self, positions: np.ndarray, rotations: np.ndarray, wrenches: np.ndarray
    ) -> np.ndarray:
        """Return Σ f_z p / Σ f_z, shape (n, 3), over the soles, `p` each sole's own centre.

        Args:
            positions: Centres of the soles, m, shape (soles, n, 3).
            rotations: Axes of the soles, shape (soles, n, 3, 3).
            wrenches: Measured wrenches in sole axes, N, N·m, shape (soles, n, 6).
        """
        loaded = wrenches[..., 2] > self._min_force
        force = np.where(loaded, wrenches[..., 2], 0.0)
        lever = np.zeros_like(positions)  # f_z times the centre of pressure, sole axes
        lever[..., 0], lever[..., 1] = -wrenches[..., 4], wrenches[..., 3]
        lever[~loaded] = 0.0
        moment = force[..., None] * positions + (rotations @ lever[..., None])[..., 0]
        total = force.sum(axis=0)[:, None]
        cop = np.full(positions.shape[1:], np.nan)
        np.divide(moment.sum(axis=0), total, out=cop, where=total > 0.0)
        return cop

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
