"""The loop: measure, estimate, control, act — simulated or in real time."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from wbc.balance import fall_reason
from wbc.command import Command, Status
from wbc.errors import WbcError
from wbc.estimation import Estimator
from wbc.gait.planar import wrap
from wbc.measurement import Measurement
from wbc.report import Report
from wbc.robot import Robot
from wbc.state import State
from wbc.view.snapshot import Snapshot

_SPIN = 300e-6  # s: the scheduler wakes a sleeper up to this late
_STRIDE = 0.5  # s between the points over which the way is added up


class StopRun(Exception):
    """Raised in `before_tick` or `progress`: ends the run early, with the report so far."""


class Controller(Protocol):
    """Anything that turns states into commands runs in `run`.

    A controller may also have `telemetry`, `dcm_error` (m) and `steps`: they are shown and
    reported when they are there.
    """

    def reset(self, state: State) -> None:
        """Start anew from a state."""

    def step(
        self, state: State, foot_wrenches: Mapping[str, np.ndarray] | None = None
    ) -> Command:
        """One tick."""


class Plant(Protocol):
    """Anything that can be measured and commanded runs in `run`.

    A plant may also have `ground_truth() -> State`: falls, distances and joint limits are then
    judged on it instead of on the estimate. The estimate never sees it.
    """

    robot: Robot
    dt: float

    @property
    def time(self) -> float:
        """s since the last reset."""

    def measure(self) -> Measurement:
        """Sensor readings now."""

    def step(self, command: Command) -> None:
        """Hold a command for one control period."""


class StateEstimator(Protocol):
    """Turns measurements into states."""

    def reset(self, state: State) -> None:
        """Start anew at a known state."""

    def update(self, measurement: Measurement) -> State:
        """The state now."""


class Observer(Protocol):
    """A viewer or recording: gets a snapshot after ticks, and never waits."""

    def show(self, snapshot: Snapshot) -> None:
        """Take what is wanted of the snapshot, at once."""


def run(
    controller: Controller,
    plant: Plant,
    duration: float,
    *,
    estimator: StateEstimator | None = None,
    viewer: Observer | None = None,
    recording: Observer | None = None,
    real_time: bool = False,
    before_tick: Callable[[float], None] | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Report:
    """Run a controller on a plant until the duration is over or the robot falls.

    Each control period: `plant.measure()` → `estimator.update` → `controller.step` →
    `plant.step`. The run starts from where the plant is: a simulator from its last reset.

    Args:
        controller: e.g. a `Walker`.
        plant: e.g. `wbc.sim.Mujoco`.
        duration: s of plant time.
        estimator: measurement to state; `Estimator(plant.robot, plant.dt)` when left out.
        viewer: shown a snapshot 30 times per second of plant time.
        recording: likewise.
        real_time: wait for the wall clock, so that a second takes a second.
        before_tick: called with the plant's time before each tick, to change commands or push.
        progress: called about ten times a second.
            Either of them may raise `StopRun` to end the run.

    Raises:
        WbcError: the duration is not positive, or the run was stopped before its first tick.
    """
    if not duration > 0.0:
        raise WbcError(f"duration = {duration} s must be positive")
    estimator = estimator or Estimator(plant.robot, plant.dt)
    observers = [o for o in (viewer, recording) if o is not None]
    start = _truth(plant) or plant.robot.standing()
    estimator.reset(start)
    controller.reset(start)
    book = _Book(plant.robot, start, int(np.ceil(duration / plant.dt)) + 1)
    clock = _Clock(plant.dt, book.lateness) if real_time else None
    show_every = max(1, round(1.0 / (30.0 * plant.dt)))
    tell_every = max(1, round(0.1 / plant.dt))
    end = plant.time + duration - 0.5 * plant.dt
    collecting = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()  # a collection in mid-tick costs tens of milliseconds; nothing here makes cycles
    try:
        tick = 0
        while plant.time < end:
            if clock is not None:
                clock.wait()
            if before_tick is not None:
                before_tick(plant.time)
            measurement = plant.measure()
            t0 = time.perf_counter()
            state = estimator.update(measurement)
            t1 = time.perf_counter()
            command = controller.step(state, measurement.foot_wrenches or None)
            t2 = time.perf_counter()
            now = plant.time
            plant.step(command)
            truth = _truth(plant) or state
            book.note(now, t1 - t0, t2 - t1, command, truth, controller)
            if tick % show_every == 0:
                for observer in observers:
                    observer.show(_snapshot(now, state, measurement, command, controller))
            if progress is not None and tick % tell_every == 0:
                progress(book.progress(now, duration))
            reason = fall_reason(plant.robot, truth, book.ground)
            if reason:
                book.fell(plant.time, reason)
                break
            tick += 1
    except StopRun as stop:
        if book.empty:
            raise WbcError(f"the run was stopped before its first tick: {stop}") from stop
        book.stopped(str(stop) or "stopped")
    finally:
        gc.unfreeze()
        if collecting:
            gc.enable()
    return book.report(controller)


class Progress:
    """What a progress line shows.

    Attributes:
        time: plant time, s.
        duration: of the whole run, s.
        speed: of the last second, m/s.
        dcm_error: m.
        tick_us: median of the recent ticks, µs.
    """

    __slots__ = ("dcm_error", "duration", "speed", "tick_us", "time")

    def __init__(
        self, time: float, duration: float, speed: float, dcm_error: float, tick_us: float
    ) -> None:
        self.time = time
        self.duration = duration
        self.speed = speed
        self.dcm_error = dcm_error
        self.tick_us = tick_us


def _truth(plant: Plant) -> State | None:
    method = getattr(plant, "ground_truth", None)
    return None if method is None else method()


def _snapshot(
    now: float, state: State, measurement: Measurement, command: Command, controller: Controller
) -> Snapshot:
    wrenches = measurement.foot_wrenches or command.wrenches
    telemetry = getattr(controller, "telemetry", None)
    text = command.explanation
    if telemetry is None:
        return Snapshot(now, state.q, wrenches, status=command.status, text=text)
    return Snapshot(now, state.q, wrenches, telemetry, command.status, text)


class _Clock:
    """Waits for the next period of the wall clock: sleeps, then spins the last stretch."""

    def __init__(self, dt: float, lateness: list[float]) -> None:
        self._dt = dt
        self._next = time.perf_counter()
        self._lateness = lateness

    def wait(self) -> None:
        left = self._next - time.perf_counter()
        if left > _SPIN:
            time.sleep(left - _SPIN)
        while (now := time.perf_counter()) < self._next:
            pass
        late = now - self._next
        self._lateness.append(late)
        # After a long hold-up, do not race to catch up.
        self._next = self._next + self._dt if late < 10.0 * self._dt else now + self._dt


class _Book:
    """Keeps the figures of a run; arrays are allocated before it starts."""

    def __init__(self, robot: Robot, start: State, ticks: int) -> None:
        self.robot = robot
        self.lateness: list[float] = []
        self.ground = float(start.q[2] - robot.q_nominal[2])
        self._start = start
        self._tick = np.zeros(ticks)
        self._estimate = np.zeros(ticks)
        self._error = np.zeros(ticks)
        self._count = 0
        self._time = 0.0
        self._first_time: float | None = None
        self._failures = 0
        self._explanation = ""
        self._peak_ratio = self._torque_excess = self._joint_excess = 0.0
        self._fell_at: float | None = None
        self._fell_why = ""
        self._stopped = False
        self._trail = [start.q[:2].copy()]
        self._trail_time = [0.0]
        self._yaw = _yaw(start)
        self._start_yaw = self._yaw
        self._turned = 0.0
        self._wall = time.perf_counter()

    def note(
        self,
        now: float,
        estimate: float,
        tick: float,
        command: Command,
        truth: State,
        controller: Controller,
    ) -> None:
        k = min(self._count, self._tick.size - 1)
        if self._first_time is None:
            self._first_time = now
        self._time = now - self._first_time
        self._tick[k], self._estimate[k] = tick, estimate
        self._error[k] = getattr(controller, "dcm_error", np.nan)
        self._count += 1
        if command.status is not Status.OK:
            self._failures += 1
            self._explanation = self._explanation or command.explanation
        size = np.abs(command.tau)
        self._peak_ratio = max(self._peak_ratio, float((size / self.robot.tau_max).max()))
        self._torque_excess = max(
            self._torque_excess, float((size - self.robot.tau_max).max())
        )
        q = truth.q[7:]
        beyond = max(float((self.robot.q_min - q).max()), float((q - self.robot.q_max).max()))
        self._joint_excess = max(self._joint_excess, beyond)
        if self._time - self._trail_time[-1] >= _STRIDE:
            self._trail.append(truth.q[:2].copy())
            self._trail_time.append(self._time)
            yaw = _yaw(truth)
            self._turned += wrap(yaw - self._yaw)
            self._yaw = yaw
        self._last = truth

    def fell(self, at: float, why: str) -> None:
        self._fell_at, self._fell_why = at, why

    @property
    def empty(self) -> bool:
        return self._count == 0

    def stopped(self, why: str) -> None:
        self._stopped, self._fell_why = True, why

    def progress(self, now: float, duration: float) -> Progress:
        k = self._count
        recent = slice(max(0, k - 50), k)
        back = max(0, len(self._trail) - 3)
        span = self._trail_time[-1] - self._trail_time[back]
        way = float(np.linalg.norm(self._trail[-1] - self._trail[back]))
        return Progress(
            now,
            duration,
            way / span if span > 0.0 else 0.0,
            float(self._error[k - 1]),
            1e6 * float(np.median(self._tick[recent])),
        )

    def report(self, controller: Controller) -> Report:
        wall = time.perf_counter() - self._wall
        n = min(self._count, self._tick.size)
        tick, errors = 1e6 * self._tick[:n], self._error[:n]
        errors = errors[np.isfinite(errors)]
        trail = np.array([*self._trail, self._last.q[:2]])
        strides = np.linalg.norm(np.diff(trail, axis=0), axis=1)
        turned = self._turned + wrap(_yaw(self._last) - self._yaw)
        moving = strides[:-1] > 0.02 * _STRIDE
        walking = float(moving.sum()) * _STRIDE
        c, s = np.cos(self._start_yaw), np.sin(self._start_yaw)
        dx, dy = self._last.q[:2] - self._start.q[:2]
        simulated = self._time + (self._fell_at is None) * 0.0
        late = 1e6 * np.array(self.lateness) if self.lateness else np.zeros(1)
        period = 1e6 * (self._time / max(self._count - 1, 1))
        return Report(
            robot=self.robot.name,
            survived=self._fell_at is None and not self._stopped,
            fell_at_s=self._fell_at,
            fell_why=self._fell_why,
            duration_s=simulated,
            steps=int(getattr(controller, "steps", 0)),
            distance_m=float(strides.sum()),
            displacement_m=(float(c * dx + s * dy), float(c * dy - s * dx)),
            turned_rad=turned,
            mean_speed_m_s=float(strides[:-1][moving].sum()) / walking if walking else 0.0,
            dcm_error_rms_mm=1e3 * float(np.sqrt(np.mean(errors**2))) if errors.size else 0.0,
            torque_peak_ratio=self._peak_ratio,
            torque_excess_nm=self._torque_excess,
            joint_limit_excess_rad=self._joint_excess,
            qp_failures=self._failures,
            explanation=self._explanation,
            tick_p50_us=float(np.percentile(tick, 50)),
            tick_p99_us=float(np.percentile(tick, 99)),
            tick_max_us=float(tick.max()),
            estimator_p50_us=1e6 * float(np.median(self._estimate[:n])),
            real_time_factor=self._time / wall if wall > 0.0 else 0.0,
            overruns=int((late > period).sum()),
            lateness_p99_us=float(np.percentile(late, 99)),
        )


def _yaw(state: State) -> float:
    x, y, z, w = state.q[3:7]
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
