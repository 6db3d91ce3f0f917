"""`LoggedRun`: a log as arrays over time, to be drawn, compared and played."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from wbc.errors import did_you_mean
from wbc.log.errors import LogError
from wbc.log.metadata import STRETCH
from wbc.log.reader import Log
from wbc.log.robot_info import RobotInfo
from wbc.log.time_span import WHOLE_RUN, TimeSpan
from wbc.messages import Message
from wbc.runtime.event import FALL, RESET, RunEvent
from wbc.runtime.quantities import STATUSES
from wbc.runtime.schema import ODOM, WRENCH, XYZ, Column, columns_from_json
from wbc.runtime.snapshot import Snapshot
from wbc.telemetry import PHASES, SIDES, ContactPlan, Footstep, Telemetry
from wbc.topics import column_fields

_STATE = "/controller_state"
_LATE = 1.5  # s; older plans are not shown
_HELD = ("true_q", "true_v", "sole_pose/")  # not sent in every tick: the latest value counts
_POSE = (*XYZ, "qx", "qy", "qz", "qw")
_COP = Column(
    name="cop",
    doc="measured centre of pressure of both feet",
    unit="m",
    labels=XYZ,
    scalar=False,
    frame=ODOM,
    message="point",
    topic="",
    single=False,
)
#: What the log writer computes from the ticks, by how the topics' names begin.
_COMPUTED = {
    "/balance/cop": _COP,
    "/sole_pose/": replace(
        _COP, name="sole_pose/", doc="pose of the sole", labels=_POSE, message="composite"
    ),
    "/command/wrench/": replace(
        _COP, name="commanded_wrench/", doc="commanded wrench at the contact", unit="N, N·m",
        labels=WRENCH, frame="", message="wrench",
    ),
}  # fmt: skip


class LoggedRun:
    """A logged run as arrays with one row per tick.

    Example:
        >>> run = LoggedRun.read("walk.mcap")
        >>> run.quantities["tau"].unit
        'N·m'
        >>> peak = abs(run["tau"]).max(axis=0)

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
            part = "" if log.span.whole else f" from {log.span}"
            raise LogError(f"{log.path} holds no tick{part}")
        self.stamps = log[_STATE].stamps
        self.time = 1e-9 * self.stamps
        self._values: dict[str, np.ndarray] = {}

    @staticmethod
    def read(
        path: str | Path,
        span: TimeSpan = WHOLE_RUN,
        progress: Callable[[float], None] = lambda share: None,
    ) -> LoggedRun:
        """Read the run in a file.

        Args:
            path: Path of the log.
            span: Part of the run to read.
            progress: Called with the share of the file that has been read, 0 to 1.

        Raises:
            LogError: See `Log` and `LoggedRun`.
            MissingExtra: `mcap` or `rosbags` is not installed.
        """
        return LoggedRun(Log(path, span=span, progress=progress))

    def __len__(self) -> int:
        """Return the number of ticks."""
        return len(self.stamps)

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the quantities."""
        return iter(self.quantities)

    def __contains__(self, name: object) -> bool:
        """Return whether the log has a quantity."""
        return name in self.quantities

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values of a quantity, NaN where unknown.

        The shape is (n,) for a number and (n, k) for an array. `true_q`, `true_v` and `sole_pose/…`
        are logged at a lower rate: their values are the latest ones.

        Args:
            name: Name of one of the `quantities`.

        Raises:
            LogError: The log has no such quantity.
        """
        if name not in self._values:
            self._values[name] = self._read(name)
        return self._values[name]

    @cached_property
    def quantities(self) -> Mapping[str, Column]:
        """Description of each quantity by its name.

        These are the quantities of the tick (`wbc.runtime.quantities` and those given to
        `wbc.run`), the commanded wrench of each contact (`commanded_wrench/…`, contact axes), the
        pose of each sole (`sole_pose/…`), and the measured centre of pressure (`cop`), where there
        is one.

        Raises:
            LogError: The log does not describe its quantities.
        """
        try:
            columns = list(columns_from_json(self.log.files["quantities.json"]))
        except (KeyError, ValueError, TypeError) as error:
            raise LogError(f"{self.log.path} does not describe its quantities") from error
        for topic in self.log:
            for prefix, column in _COMPUTED.items():
                if topic.startswith(prefix):
                    name = column.name + topic.removeprefix(prefix)
                    columns.append(replace(column, name=name, topic=topic[1:]))
        return {c.name: c for c in sorted(columns, key=lambda c: c.name) if _fields(c)}

    @property
    def title(self) -> str:
        """Robot, duration and outcome of the run, with its falls and resets."""
        is_stretch = STRETCH in self.log.tables
        text = f"{self.robot_info.name}, "
        if is_stretch or not self.log.span.whole:
            text += f"{self.time[0]:.1f} s to "
        text += f"{self.time[-1]:.1f} s"
        report = self.log.tables.get("report")
        if report is None:
            if is_stretch:
                text += " of a session"
            else:  # the process of the loop was killed; without an end, that of the log as well
                text += ", ended without a report" if self.log.complete else ", interrupted"
        elif report.get("survived") != "True":
            text += f": {report.get('fell_why', 'fell')}"
        for kind, name in ((FALL, "fall"), (RESET, "reset")):
            if count := sum(event.kind == kind for event in self.events):
                text += f", {count} {name}{'s' * (count > 1)}"
        return text

    @cached_property
    def events(self) -> list[RunEvent]:
        """Commands, falls and resets in order of time, which is that of the log."""
        if "/events" not in self.log:
            return []
        table = self.log["/events"]
        found = [
            RunEvent(
                1e-9 * stamp, message.kind, message.source, int(message.number), message.name,
                message.value, message.outcome, message.reason,
            )
            for stamp, message in zip(table.stamps.tolist(), table.messages(), strict=True)
        ]  # fmt: skip
        return sorted(found, key=lambda one: one.time)

    @cached_property
    def _resets(self) -> np.ndarray:
        """Times of the resets, s."""
        return np.array([event.time for event in self.events if event.kind == RESET])

    @cached_property
    def plans(self) -> list[ContactPlan]:
        """The contact plans, in the order of `plan_stamps`."""
        if "/footsteps" not in self.log:
            return []
        parts = (self.log[t].messages() for t in ("/support_polygon", "/footsteps", "/swing_path"))
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
        footsteps = self.log.topics.get("/footsteps")
        return np.empty(0, np.int64) if footsteps is None else footsteps.stamps

    def at(self, time: float) -> Snapshot:
        """Return the snapshot of the last tick at or before a time (s), or of the first tick."""
        tick = max(int(np.searchsorted(self.time, time + 1e-9, "right")) - 1, 0)
        plan = int(np.searchsorted(self.plan_stamps, self.stamps[tick], "right")) - 1
        late = plan < 0 or self.stamps[tick] - self.plan_stamps[plan] >= 1e9 * _LATE
        points = {name: self[name][tick] for name in ("com", "dcm", "dcm_reference", "zmp")}
        return Snapshot(
            time=float(self.time[tick]),
            q=self["q"][tick],
            wrenches=self._known("foot_wrench/", tick) or self._known("commanded_wrench/", tick),
            telemetry=Telemetry(**points, phase=PHASES[int(self["phase"][tick])]),
            contact_plan=ContactPlan() if late else self.plans[plan],
            status=STATUSES[int(self["status"][tick])],
            run=1 + int(np.searchsorted(self._resets, self.time[tick] + 1e-9, "right")),
        )

    @property
    def start(self) -> float:
        """Time of the first tick, s."""
        return float(self.time[0])

    @property
    def end(self) -> float:
        """Time of the last tick, s."""
        return float(self.time[-1])

    def _read(self, name: str) -> np.ndarray:
        column = self.quantities.get(name)
        if column is None:
            near = did_you_mean(name, self.quantities)
            raise LogError(f"{self.log.path} has no quantity '{name}'{near}")
        fields = _fields(column)
        if not all(topic in self.log for topic, _ in fields):
            return np.full((len(self), *(() if column.scalar else (column.size,))), np.nan)
        held = name.startswith(_HELD)
        values = np.hstack([self._at_ticks(topic, field, held) for topic, field in fields])
        return values[:, 0] if column.scalar else values

    def _at_ticks(self, topic: str, field: str, held: bool) -> np.ndarray:
        """Return a field at every tick; at ticks without a message, NaN or the latest value."""
        values: np.ndarray = self.log[topic].numbers(field)
        stamps = self.log[topic].stamps
        if np.array_equal(stamps, self.stamps):
            return values
        latest = np.maximum(np.searchsorted(stamps, self.stamps, "right") - 1, 0)
        values = values[latest]
        if not held:
            values[stamps[latest] != self.stamps] = np.nan
        return values

    def _known(self, prefix: str, tick: int) -> dict[str, np.ndarray]:
        """Return the known values of the quantities whose names begin with a prefix."""
        found = {
            name.removeprefix(prefix): self[name][tick] for name in self if name.startswith(prefix)
        }
        return {name: value for name, value in found.items() if np.isfinite(value).all()}


def _fields(column: Column) -> list[tuple[str, str]]:
    """Return the topics and fields that carry a quantity; none if it is not logged."""
    if column.name.startswith("sole_pose/"):
        return [(f"/{column.topic}", "pose")]
    return [(f"/{topic}", field) for topic, field in column_fields(column)]


def _xyz(points: list[Message]) -> np.ndarray:
    return np.array([(p.x, p.y, p.z) for p in points], float).reshape(-1, 3)


def _footstep(step: Message) -> Footstep:
    pose = step.pose
    yaw = 2.0 * float(np.arctan2(pose.orientation.z, pose.orientation.w))
    position = np.array([pose.position.x, pose.position.y, pose.position.z])
    return Footstep(SIDES[step.side], position, yaw)
