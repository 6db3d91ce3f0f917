"""A trajectory of joints, parsed from `trajectory_msgs/msg/JointTrajectory`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.ros.stamp import to_seconds
from wbc.teleop import CommandRefused

_SAMPLES = np.linspace(0.0, 1.0, 9)  # of a segment, at which its velocity is checked
_ROUNDING = 1.001  # by which a velocity may exceed its limit


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Joint positions over time: cubic between points with velocities, otherwise linear.

    Attributes:
        joints: names of the joints.
        times: times of the points after the start, s, increasing, shape (points,).
        positions: rad, shape (points, joints).
        velocities: rad/s, shape (points, joints); None between whose points the path is linear.
    """

    joints: tuple[str, ...]
    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None = None

    @staticmethod
    def parse(message: Any) -> JointTrajectory:
        """Return the trajectory of a message.

        Raises:
            CommandRefused: there are no points, their times do not increase, or a point has other
                numbers than the joints need.
        """
        joints, points = tuple(message.joint_names), message.points
        if not points:
            raise CommandRefused("the trajectory has no points")
        times = np.array([to_seconds(point.time_from_start) for point in points])
        if times[0] < 0.0 or not (np.diff(times) > 0.0).all():
            raise CommandRefused("the times of the points do not increase")
        positions = _table([point.positions for point in points], len(joints), "positions")
        velocities = None
        if any(len(point.velocities) for point in points):
            velocities = _table([point.velocities for point in points], len(joints), "velocities")
        return JointTrajectory(joints, times, positions, velocities)

    def at(self, time: float) -> np.ndarray:
        """Return the positions at a time after the start, rad; those of the ends outside of it."""
        last = len(self.times) - 1
        k = int(np.searchsorted(self.times, time, "right")) - 1
        if k < 0 or k >= last:
            return np.array(self.positions[0 if k < 0 else last])
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        positions: np.ndarray = self._segment(k, np.array([share]))[0][0]
        return positions

    def _segment(self, k: int, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and velocities, (n, joints), in segment k, at shares of its time."""
        s, start, end = share[:, None], self.positions[k], self.positions[k + 1]
        duration = self.times[k + 1] - self.times[k]
        if self.velocities is None:
            return start + s * (end - start), (end - start) / duration + 0.0 * s
        v, w = duration * self.velocities[k], duration * self.velocities[k + 1]
        # Cubic Hermite interpolation.
        b, c = 3.0 * (end - start) - 2.0 * v - w, 2.0 * (start - end) + v + w
        return start + s * (v + s * (b + s * c)), (v + s * (2.0 * b + 3.0 * s * c)) / duration

    def check_velocity(self, limits: np.ndarray) -> None:
        """Refuse a trajectory whose velocities exceed limits, rad/s, (joints,).

        Raises:
            CommandRefused: the text names the joint, its velocity and its limit.
        """
        for k in range(len(self.times) - 1):
            largest = np.abs(self._segment(k, _SAMPLES)[1]).max(axis=0)
            for name, velocity, limit in zip(self.joints, largest, limits, strict=True):
                if velocity > _ROUNDING * limit:
                    raise CommandRefused(
                        f"'{name}' would move at {velocity:.2f} rad/s between points {k} and "
                        f"{k + 1}; at most {limit:.2f} rad/s"
                    )


def _table(rows: Sequence[Any], count: int, what: str) -> np.ndarray:
    for row in rows:
        if len(row) != count:
            raise CommandRefused(f"{count} joints have {len(row)} {what}")
    table = np.array(rows, float).reshape(len(rows), count)
    if not np.isfinite(table).all():
        raise CommandRefused(f"one of the {what} is not finite")
    return table
