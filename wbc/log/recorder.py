"""`FlightRecorder`: a log of every tick, written by a process of its own."""

from __future__ import annotations

import importlib.util
import logging
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.closeable import Closeable
from wbc.command import Status
from wbc.errors import MissingExtra
from wbc.log.describe import Facts, run_facts
from wbc.log.errors import LogError
from wbc.log.layout import (
    CONTACTS,
    FOOTSTEPS,
    STATUSES,
    SUPPORT,
    SWING,
    TEXT,
    Layout,
)
from wbc.log.order import Order
from wbc.log.recovery import repair
from wbc.log.ring import TickRing
from wbc.process import ChildProcess, ProcessStartError
from wbc.telemetry import PHASES, Balance, Telemetry

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.tick import Tick

logger = logging.getLogger(__name__)

_CAPACITY = 4096  # ticks: eight seconds at 500 Hz
_PLAN_RATE = 30.0  # Hz, of support, footsteps and swing
_LOOK = 0.5  # s, between two looks whether the process is still there
_GRACE = 20.0  # s, for it to write what is there and end
_UNKNOWN = Balance()
_NO_VELOCITY = (np.nan, np.nan, np.nan)
_NO_PLAN = (0, 0, 0, 0)
_NO_WRENCH = np.full(6, np.nan)
_PHASE = {phase: i for i, phase in enumerate(PHASES)}


class FlightRecorder(Closeable):
    """Keeps every tick of a run in an MCAP file of ROS 2 messages.

    A tick is copied into shared memory, some microseconds; another process makes messages of
    it and writes them, in chunks that end twice a second: whichever process is killed, the
    file can be read up to the last second. When the disk is full, the log ends and the run
    goes on.

    Example:
        >>> with FlightRecorder("walk.mcap", robot) as log:
        ...     wbc.run(walker, plant, 10.0, log=log)

    Args:
        path: of the file; one that is there is overwritten.
        robot: the robot.
        capacity: number of ticks that may wait to be written.

    Raises:
        MissingExtra: `zstandard` is not installed.
        LogError: the file cannot be written, or the process does not start.
    """

    def __init__(self, path: str | Path, robot: Robot, *, capacity: int = _CAPACITY) -> None:
        if importlib.util.find_spec("zstandard") is None:
            raise MissingExtra("zstandard", "log")
        self.path = Path(path)
        self._robot = robot
        self._layout = layout = Layout.of(robot)
        self._ring = TickRing(layout, capacity)
        self._bodies = [row[layout.body_slice] for row in self._ring.flat]
        self._text = layout.slices("text")
        self._plan = [layout.slices(name) for name in ("support", "footsteps", "swing")]
        self._soles = [sole.name for sole in robot.soles]
        self._no_truth = (np.full(robot.nq, np.nan), np.full(robot.nv, np.nan))
        self._padding = [np.full(7 * k, np.nan) for k in range(CONTACTS + 1)]
        self._names: dict[str, np.ndarray] = {}
        self._plan_due = self._last = -np.inf
        self._before = self._look = 0.0
        self._tick = 0
        self._told = self._closed = self._introduced = False
        self._process = ChildProcess("wbc.log.writer", (self._ring.descriptor,), _GRACE)
        order = Order.of(robot, self.path, self._ring.descriptor, capacity, os.getpid())
        try:
            self._process.configure(order)
            self._introduced = True
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise LogError(f"the log {self.path}: {error}") from error
            raise

    @property
    def alive(self) -> bool:
        """Whether the log goes on."""
        return not self._ring.stopped and self._process.alive

    @property
    def pid(self) -> int:
        """Of the process that writes."""
        return self._process.pid

    @property
    def ticks(self) -> int:
        """Ticks so far that were kept."""
        return self._ring.written

    @property
    def dropped(self) -> int:
        """Ticks so far that were not kept, because the writing process was too slow."""
        return self._ring.dropped

    def begin(self, controller: Controller, plant: Plant) -> None:
        """A run begins: its parameters go into the log. See `wbc.runtime.protocols.Recorder`."""
        self._plan_due = self._last = -np.inf
        self._before = time.perf_counter()
        self._process.send(run_facts(controller, plant))

    def record(self, tick: Tick, controller: Controller) -> None:
        """Keep a tick. Never waits; whatever happens to the file, returns.

        Raises:
            LogError: an array of the tick has the wrong size.
        """
        now = time.perf_counter()
        period, self._before = now - self._before, now
        if now >= self._look:
            self._look_after(now)
        ring = self._ring
        if self._told or self._closed or (index := ring.claim()) < 0:
            self._tick += 1
            return
        command, measurement = tick.command, tick.measurement
        plan = self._plan_of(tick.time, controller)
        balance: Balance = plan or _balance(controller)
        truth, feet = tick.truth, measurement.foot_wrenches
        pieces = [
            tick.estimate.state.q,
            tick.estimate.state.v,
            command.tau,
            command.acceleration,
            command.q_target,
            command.v_target,
            measurement.joint_position,
            measurement.joint_velocity,
            measurement.gyro,
            measurement.accelerometer,
            balance.com,
            balance.dcm,
            balance.dcm_reference,
            balance.zmp,
        ]
        pieces += self._no_truth if truth is None else (truth.q, truth.v)
        for sole in self._soles:
            pieces.append(feet.get(sole, _NO_WRENCH))
        self._add_contacts(pieces, command.wrenches)
        try:
            np.concatenate(pieces, out=self._bodies[index])
        except ValueError as error:
            raise LogError(self._misfit(tick, balance)) from error
        text = self._write_text(index, command.explanation) if command.explanation else 0
        ring.write_head(
            index,
            tick.time,
            self._tick,
            0 if command.status is Status.OK else STATUSES.index(command.status),
            _PHASE.get(balance.phase, 0),
            getattr(controller, "steps", 0),
            tick.estimator_time,
            tick.controller_time,
            period,
            getattr(controller, "dcm_error", np.nan),
            *getattr(controller, "velocity", _NO_VELOCITY),
            text,
            *(_NO_PLAN if plan is None else self._write_plan(index, plan)),
        )
        ring.publish()
        self._tick += 1

    def _plan_of(self, now: float, controller: Controller) -> Telemetry | None:
        """The controller's whole telemetry when it is due, which costs some 0.1 ms."""
        if self._last <= now < self._plan_due:
            self._last = now
            return None
        self._last = now
        self._plan_due = now + 1.0 / _PLAN_RATE - 1e-9
        return getattr(controller, "telemetry", None)

    def _add_contacts(self, pieces: list[np.ndarray], wrenches: dict[str, np.ndarray]) -> None:
        room = CONTACTS
        for name, wrench in wrenches.items():
            number = self._names.get(name)
            if number is None:
                number = self._names[name] = np.array([float(self._ring.name(name))])
            if room:
                pieces += (number, wrench)
                room -= 1
        pieces.append(self._padding[room])

    def _write_text(self, index: int, text: str) -> int:
        """Write the explanation; returns its size in bytes."""
        data = text.encode("utf-8", "replace")[:TEXT]
        place = self._ring.flat[index, self._text].view(np.uint8)
        place[: len(data)] = np.frombuffer(data, np.uint8)
        return len(data)

    def _write_plan(self, index: int, plan: Telemetry) -> tuple[int, int, int, int]:
        """Write the plan; returns 1 and the sizes of its parts."""
        support, footsteps, swing = (self._ring.flat[index, part] for part in self._plan)
        polygon = np.asarray(plan.support, float)[:SUPPORT].ravel()
        support[: polygon.size] = polygon
        steps = plan.footsteps[:FOOTSTEPS]
        for row, step in zip(footsteps.reshape(FOOTSTEPS, 5), steps, strict=False):
            row[0] = step.side == "right"
            row[1:4] = step.position
            row[4] = step.yaw
        path = np.asarray(plan.swing_path, float)[:SWING].ravel()
        swing[: path.size] = path
        return (1, polygon.size // 3, len(steps), path.size // 3)

    def _misfit(self, tick: Tick, balance: Balance) -> str:
        """Which array has the wrong size."""
        places = (tick.estimate.state, tick.command, tick.measurement, balance)
        for name, size in self._layout.body:
            for place in places:
                if not hasattr(place, name):
                    continue
                shape = np.shape(getattr(place, name))
                if shape != (size,):
                    kind = type(place).__name__
                    return f"{kind}.{name} has shape {shape}; the log of this robot needs ({size},)"
        return "a wrench of the tick is not of six numbers, or the ground truth has a wrong size"

    def _look_after(self, now: float) -> None:
        """Report the end of the log, once."""
        self._look = now + _LOOK
        code = self._process.exit_code
        if self._told or (code in (None, 0) and not self._ring.stopped):
            return
        self._told = True
        reason = self._ring.reason or f"its process ended (exit code {code})"
        logger.warning("the log %s ends here: %s; the run goes on without it", self.path, reason)

    def end(self, report: Report) -> None:
        """The run is over: its figures go into the log. See `wbc.runtime.protocols.Recorder`."""
        facts = {name: str(getattr(report, name)) for name in report.__dataclass_fields__}
        self._process.send(Facts({"report": facts}))

    def close(self) -> None:
        """Finish the file. Tells if ticks are missing in it."""
        if self._closed:
            return
        self._closed = True
        self._process.close()
        if self._introduced:
            self._finish()
        self._ring.close()

    def _finish(self) -> None:
        """What the writing process could not do, and what is to be said."""
        self._look_after(np.inf)
        if self._process.exit_code != 0 and not self._ring.stopped:
            logger.warning("the log %s now ends at %.2f s", self.path, repair(self.path))
        if self.dropped:
            logger.warning(
                "%d of %d ticks are not in %s: the writing process was too slow",
                self.dropped,
                self.dropped + self.ticks,
                self.path,
            )


def _balance(controller: Controller) -> Balance:
    found: Balance | None = getattr(controller, "balance", None)
    if found is None:
        found = getattr(controller, "telemetry", None)
    return _UNKNOWN if found is None else found
