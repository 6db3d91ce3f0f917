"""`LoggedRun`: a log as arrays over time, to be drawn, compared and played."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import numpy as np

from wbc.errors import did_you_mean
from wbc.log.errors import LogError
from wbc.log.reader import Log
from wbc.log.robot_info import RobotInfo
from wbc.messages import Message
from wbc.runtime.quantities import STATUSES
from wbc.runtime.schema import Column, columns_from_json
from wbc.runtime.snapshot import Snapshot
from wbc.telemetry import PHASES, SIDES, ContactPlan, Footstep, Telemetry
from wbc.topics.catalogue import COMPOSITE_FIELDS, column_topic

_STATE = "/controller_state"
_LATE = 1.5  # s; older plans are not shown


class LoggedRun:
    """A logged run as arrays with one row per tick; unknown values are NaN.

    Args:
        log: Log of the run.

    Attributes:
        log: Log of the run.
        robot_info: Properties of the robot.
        stamps: Times of the ticks, ns, shape (n,).
        time: Times of the ticks, s, shape (n,).

    Raises:
        LogError: The log does not describe a run, or holds no tick.
    """

    def __init__(self, log: Log) -> None:
        self.log = log
        self.robot_info: RobotInfo = log.robot_info()
        if _STATE not in log:
            raise LogError(f"{log.path} holds no tick")
        self.stamps = log.stamps(_STATE)
        self.time = 1e-9 * self.stamps

    @staticmethod
    def read(path: str | Path) -> LoggedRun:
        """Read the run in a file.

        Raises:
            LogError: See `Log` and `LoggedRun`.
            MissingExtra: `mcap` is not installed.
        """
        return LoggedRun(Log(path))

    def __len__(self) -> int:
        """Return the number of ticks."""
        return len(self.stamps)

    @property
    def title(self) -> str:
        """Robot, duration and outcome of the run."""
        report = self.log.tables.get("report")
        if report is None:
            return f"{self.robot_info.name}, {self.time[-1]:.1f} s, interrupted"
        if report.get("survived") == "True":
            return f"{self.robot_info.name}, {self.time[-1]:.1f} s"
        return f"{self.robot_info.name}, {self.time[-1]:.1f} s: {report.get('fell_why', 'fell')}"

    @cached_property
    def q(self) -> np.ndarray:
        """Estimated configurations; m, unit quaternion, rad; shape (n, nq)."""
        return np.hstack(
            [self.at_ticks("/odom", "pose.pose"), self.at_ticks("/joint_states", "position")]
        )

    @cached_property
    def v(self) -> np.ndarray:
        """Estimated velocities, base twist in the base frame; m/s, rad/s; shape (n, nv)."""
        return np.hstack(
            [self.at_ticks("/odom", "twist.twist"), self.at_ticks("/joint_states", "velocity")]
        )

    @cached_property
    def tau(self) -> np.ndarray:
        """Commanded torques, N·m or N, shape (n, na)."""
        return self.at_ticks("/joint_states", "effort")

    def point(self, name: str) -> np.ndarray:
        """Return "com", "dcm", "dcm_reference", "zmp" or "cop", m, world frame, shape (n, 3)."""
        topic = f"/balance/{name}"
        if topic not in self.log:
            return np.full((len(self), 3), np.nan)
        return self.at_ticks(topic, "point")

    def state(self, field: str) -> np.ndarray:
        """Return a field of `wbc_msgs/ControllerState`, e.g. "controller_time", shape (n,)."""
        numbers: np.ndarray = self.log.numbers(_STATE, field)[:, 0]
        return numbers

    def at_ticks(self, topic: str, field: str) -> np.ndarray:
        """Return a field of a topic at every tick, shape (n, k); NaN at ticks without a message.

        Raises:
            LogError: The log has no such topic, or its messages no such field.
        """
        numbers = self.log.numbers(topic, field)
        stamps = self.log.stamps(topic)
        if len(stamps) == len(self) and (stamps == self.stamps).all():
            return numbers
        rows = np.full((len(self), numbers.shape[1]), np.nan)
        place = np.searchsorted(self.stamps, stamps)
        there = (place < len(self)) & (self.stamps[np.minimum(place, len(self) - 1)] == stamps)
        rows[place[there]] = numbers[there]
        return rows

    @cached_property
    def foot_wrenches(self) -> Mapping[str, np.ndarray]:
        """Measured wrench of each sole by name, sole axes, N and N·m, shape (n, 6)."""
        return self._wrenches("/sensors/wrench/")

    @cached_property
    def commanded_wrenches(self) -> Mapping[str, np.ndarray]:
        """Commanded wrench of each contact by name, contact axes, N and N·m, shape (n, 6)."""
        return self._wrenches("/command/wrench/")

    @cached_property
    def soles(self) -> Mapping[str, np.ndarray]:
        """Latest known pose of each sole by name: position, m, quaternion x y z w, shape (n, 7)."""
        prefix = "/sole_pose/"
        found = {}
        for topic in self.log.topics:
            if topic.startswith(prefix):
                index = self._latest(self.log.stamps(topic))
                found[topic[len(prefix) :]] = self.log.numbers(topic, "pose")[index]
        return found

    @property
    def quantities(self) -> Mapping[str, Column]:
        """Description of each quantity of the tick that the log has, by name.

        Raises:
            LogError: The log does not describe its quantities.
        """
        try:
            columns = columns_from_json(self.log.files["quantities.json"])
        except (KeyError, ValueError, TypeError) as error:
            raise LogError(f"{self.log.path} does not describe its quantities") from error
        there = {c.name: c for c in columns if self._fields_of(c)}
        return dict(sorted(there.items()))

    def quantity(self, name: str) -> tuple[Column, np.ndarray]:
        """Return the description of a quantity and its values, shape (n, k), NaN where unknown.

        Raises:
            LogError: The log has no quantity of that name.
        """
        column = self.quantities.get(name)
        if column is None:
            near = did_you_mean(name, self.quantities)
            raise LogError(f"{self.log.path} has no quantity '{name}'{near}")
        parts = [self.at_ticks(topic, field) for topic, field in self._fields_of(column)]
        return column, np.hstack(parts)

    def _fields_of(self, column: Column) -> list[tuple[str, str]]:
        """Return the topics and fields that carry a column; empty if the log lacks them."""
        own = {"point": "point", "wrench": "wrench", "numbers": "data", "composite": ""}
        single = ((column_topic(column), own[column.message]),)
        found = [(f"/{topic}", field) for topic, field in COMPOSITE_FIELDS.get(column.name, single)]
        return found if all(topic in self.log for topic, _ in found) else []

    @cached_property
    def plans(self) -> list[ContactPlan]:
        """The contact plans, in the order of `plan_stamps`."""
        if "/footsteps" not in self.log:
            return []
        log = self.log
        parts = (log.messages(t) for t in ("/support_polygon", "/footsteps", "/swing_path"))
        return [
            ContactPlan(
                _xyz(support.polygon.points),
                tuple(_footstep(step) for step in steps.footsteps),
                _xyz([stamped.pose.position for stamped in swing.poses]),
            )
            for support, steps, swing in zip(*parts, strict=False)
        ]

    @cached_property
    def plan_stamps(self) -> np.ndarray:
        """Times of the plans, ns, shape (m,)."""
        if "/footsteps" not in self.log:
            return np.empty(0, np.int64)
        return self.log.stamps("/footsteps")

    def snapshot(self, tick: int) -> Snapshot:
        """Return the snapshot of a tick for a viewer."""
        plan = ContactPlan()
        if len(self.plan_stamps):
            index = int(np.searchsorted(self.plan_stamps, self.stamps[tick], "right")) - 1
            if index >= 0 and self.stamps[tick] - self.plan_stamps[index] < 1e9 * _LATE:
                plan = self.plans[index]
        measured = {name: w[tick] for name, w in self.foot_wrenches.items()}
        known = {name: w for name, w in measured.items() if np.isfinite(w).all()}
        if not known:
            commanded = {name: w[tick] for name, w in self.commanded_wrenches.items()}
            known = {name: w for name, w in commanded.items() if np.isfinite(w).all()}
        return Snapshot(
            time=float(self.time[tick]),
            q=self.q[tick],
            wrenches=known,
            telemetry=Telemetry(
                com=self._points["com"][tick],
                dcm=self._points["dcm"][tick],
                dcm_reference=self._points["dcm_reference"][tick],
                zmp=self._points["zmp"][tick],
                phase=PHASES[int(self._phases[tick])],
            ),
            contact_plan=plan,
            status=STATUSES[int(self._statuses[tick])],
        )

    @property
    def start(self) -> float:
        """Time of the first tick, s."""
        return float(self.time[0])

    @property
    def end(self) -> float:
        """Time of the last tick, s."""
        return float(self.time[-1])

    def at(self, time: float) -> Snapshot:
        """Return the snapshot at a time (s) for a viewer."""
        return self.snapshot(self.tick_at(time))

    def tick_at(self, time: float) -> int:
        """Return the last tick at or before a time (s), or the first tick for earlier times."""
        return max(int(np.searchsorted(self.time, time + 1e-9, "right")) - 1, 0)

    @cached_property
    def _points(self) -> dict[str, np.ndarray]:
        return {name: self.point(name) for name in ("com", "dcm", "dcm_reference", "zmp")}

    @cached_property
    def _phases(self) -> np.ndarray:
        return self.state("phase")

    @cached_property
    def _statuses(self) -> np.ndarray:
        return self.state("status")

    def _wrenches(self, prefix: str) -> dict[str, np.ndarray]:
        return {
            topic[len(prefix) :]: self.at_ticks(topic, "wrench")
            for topic in self.log.topics
            if topic.startswith(prefix)
        }

    def _latest(self, stamps: np.ndarray) -> np.ndarray:
        """Return for each tick the index of the last stamp at or before it, shape (n,)."""
        return np.maximum(np.searchsorted(stamps, self.stamps, "right") - 1, 0)


def _xyz(points: list[Message]) -> np.ndarray:
    return np.array([(p.x, p.y, p.z) for p in points], float).reshape(-1, 3)


def _footstep(step: Message) -> Footstep:
    pose = step.pose
    yaw = 2.0 * float(np.arctan2(pose.orientation.z, pose.orientation.w))
    position = np.array([pose.position.x, pose.position.y, pose.position.z])
    return Footstep(SIDES[step.side], position, yaw)
