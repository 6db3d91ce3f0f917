"""Joint and posture commands: where arms, trunk and head shall be.

The legs belong to the gait: their joints are not taken. `joint_commands` is where joints shall be
now, `joint_trajectory` where they shall be over time.
"""

from __future__ import annotations

import logging
import time
from typing import Any

import numpy as np

from wbc.errors import did_you_mean
from wbc.robot import Robot
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.node import Node
from wbc.ros.stamp import to_seconds
from wbc.ros.timer import Timer

logger = logging.getLogger(__name__)

_PERIOD = 0.02  # s between two points of a trajectory that are passed on


class CommandError(ValueError):
    """A command that cannot be followed."""


class PostureCommands:
    """Takes both kinds of commands; the latest one holds for its joints."""

    def __init__(
        self,
        node: Node,
        orders: Orders,
        mailbox: Mailbox,
        robot: Robot,
    ) -> None:
        self._node, self._orders, self._mailbox, self._robot = node, orders, mailbox, robot
        legs = {int(i) - 6 for leg in robot.legs for i in leg}
        self._free = {name: i for i, name in enumerate(robot.joint_names) if i not in legs}
        self._legs = {robot.joint_names[i] for i in legs}
        self._speed = node.declare_parameter(
            "joint_speed",
            1.0,
            "of commanded joints at the most, rad/s; half their limit if that is less",
            minimum=0.01,
            maximum=10.0,
        )
        self._trajectory: tuple[float, np.ndarray, np.ndarray, np.ndarray] | None = None
        self._timer: Timer | None = None
        node.create_subscription("sensor_msgs/msg/JointState", "joint_commands", self._hear_joints)
        node.create_subscription(
            "trajectory_msgs/msg/JointTrajectory", "joint_trajectory", self._hear_trajectory
        )

    def forget(self) -> None:
        """Nothing is wanted any more: the robot starts anew."""
        self._end_trajectory()
        self._orders.joints[:] = np.nan
        self._mailbox.post(self._orders)

    def _hear_joints(self, message: Any, _: Any) -> None:
        try:
            indices = self._indices(message.name)
            positions = self._positions(indices, message.position)
        except CommandError as error:
            logger.warning("joint_commands: ignored: %s", error)
            return
        self._end_trajectory()
        self._order(indices, positions, time.monotonic())

    def _hear_trajectory(self, message: Any, _: Any) -> None:
        try:
            indices = self._indices(message.joint_names)
            times = np.array([to_seconds(p.time_from_start) for p in message.points])
            if not times.size:
                raise CommandError("it has no points")
            if times[0] < 0.0 or not (np.diff(times) > 0.0).all():
                raise CommandError("its times do not increase")
            rows = np.array([self._positions(indices, p.positions) for p in message.points])
        except CommandError as error:
            logger.warning("joint_trajectory: ignored: %s", error)
            return
        self._end_trajectory()
        self._trajectory = (time.monotonic(), indices, times, rows)
        self._timer = self._node.create_timer(_PERIOD, self._follow)
        self._follow()

    def _follow(self) -> None:
        """Pass on where the trajectory will be a moment from now."""
        assert self._trajectory is not None
        start, indices, times, rows = self._trajectory
        arrival = time.monotonic() + _PERIOD
        at = min(max(arrival - start, times[0]), times[-1])
        positions = np.array([np.interp(at, times, column) for column in rows.T])
        # The first point may be far off: it is approached until its time.
        self._order(indices, positions, max(arrival, start + times[0]))
        if at >= times[-1]:
            self._end_trajectory()

    def _end_trajectory(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._trajectory = self._timer = None

    def _order(self, indices: np.ndarray, positions: np.ndarray, arrival: float) -> None:
        self._orders.joints[indices] = positions
        self._orders.arrival = arrival
        self._orders.joint_speed = float(self._speed.value)
        self._mailbox.post(self._orders)

    def _indices(self, names: list[str]) -> np.ndarray:
        for name in names:
            if name in self._legs:
                raise CommandError(f"'{name}' is a joint of a leg, which the gait needs")
            if name not in self._free:
                raise CommandError(f"there is no joint '{name}'{did_you_mean(name, self._free)}")
        if len(set(names)) != len(names):
            raise CommandError("a joint is named twice")
        if not names:
            raise CommandError("it names no joints")
        return np.array([self._free[name] for name in names], dtype=int)

    def _positions(self, indices: np.ndarray, positions: Any) -> np.ndarray:
        """Checked, and clamped to what the joints can do."""
        if len(positions) != len(indices):
            raise CommandError(f"{len(indices)} joints have {len(positions)} positions")
        values = np.asarray(positions, dtype=float)
        if not np.isfinite(values).all():
            raise CommandError("a position is not finite")
        return np.clip(values, self._robot.q_min[indices], self._robot.q_max[indices])
