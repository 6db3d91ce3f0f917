"""The loop: measure, estimate, control, act — simulated or in real time."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from wbc.errors import WbcError
from wbc.estimation import Estimator
from wbc.runtime.clock import Clock
from wbc.runtime.fall import fall_reason
from wbc.runtime.loop_conditions import LoopConditions
from wbc.runtime.protocols import Controller, Observer, Plant, Recorder, StateEstimator
from wbc.runtime.real_time import RealTime, punctual, uncollected
from wbc.runtime.report import Report
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.statistics import Book, Progress
from wbc.runtime.tick import Tick
from wbc.state import State


class StopRun(Exception):
    """Raised in `before_tick` or `progress`: ends the run early, with the report so far."""


class RunComplete(StopRun):
    """Raised likewise when everything is done: the run ends early, as it should."""


def run(
    controller: Controller,
    plant: Plant,
    duration: float,
    *,
    estimator: StateEstimator | None = None,
    viewer: Observer | None = None,
    recording: Observer | None = None,
    log: Recorder | Sequence[Recorder] | None = None,
    real_time: bool | RealTime = False,
    announce: Callable[[LoopConditions], None] | None = None,
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
        estimator: measurement to estimate; `Estimator(plant.robot, plant.dt)` when left out.
        viewer: shown a snapshot 30 times per second of plant time.
        recording: likewise.
        log: told every tick, e.g. `wbc.log.FlightRecorder`; or several such.
        real_time: wait for the wall clock, so that a second takes a second. The loop asks the
            system for all that keeps ticks punctual, or for what a `RealTime` says, and gives it
            back in the end.
        announce: told before the first tick of a real-time run what was granted and what was
            not; when left out, a line on standard error tells.
        before_tick: called with the plant's time before each tick, to change commands or push.
        progress: called about ten times a second.
            Either of them may raise `StopRun` to end the run, or `RunComplete` when it is done.

    Raises:
        WbcError: the duration is not positive, or the run was stopped before its first tick.
    """
    if not duration > 0.0:
        raise WbcError(f"duration = {duration} s must be positive")
    estimator = estimator or Estimator(plant.robot, plant.dt)
    observers = [o for o in (viewer, recording) if o is not None]
    true_before = _truth(plant)
    start = true_before or plant.robot.standing()
    estimator.reset(start)
    controller.reset(start)
    logs = () if log is None else tuple(log) if isinstance(log, Sequence) else (log,)
    for one in logs:
        one.begin(controller, plant)
    show_every = max(1, round(1.0 / (30.0 * plant.dt)))
    tell_every = max(1, round(0.1 / plant.dt))
    end = plant.time + duration - 0.5 * plant.dt
    with uncollected(), _conditions(real_time, announce) as conditions:
        book = Book(plant.robot, start, int(np.ceil(duration / plant.dt)) + 1)
        clock = Clock(plant.dt, book.ticks) if conditions is not None else None
        try:
            tick = 0
            expected: np.ndarray | None = None
            while plant.time < end:
                if clock is not None:
                    clock.wait()
                if before_tick is not None:
                    before_tick(plant.time)
                measurement = plant.measure()
                t0 = time.perf_counter()
                estimate = estimator.update(measurement, acceleration=expected)
                t1 = time.perf_counter()
                command = controller.step(estimate)
                t2 = time.perf_counter()
                now = plant.time
                expected = command.acceleration
                plant.step(command)
                true_state = _truth(plant)
                truth = true_state or estimate.state
                book.note(now, t1 - t0, t2 - t1, command, truth, controller)
                showing = observers if tick % show_every == 0 else ()
                if logs or showing:
                    seen = Tick(now, measurement, estimate, command, true_before, t1 - t0, t2 - t1)
                    for one in logs:
                        one.record(seen, controller)
                    if showing:
                        snapshot = Snapshot.of(seen, controller)
                        for observer in showing:
                            observer.show(snapshot)
                true_before = true_state
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
            if not isinstance(stop, RunComplete):
                book.stopped(str(stop) or "stopped")
    report = book.report(controller, clock)
    if conditions is not None:
        report = replace(report, loop_conditions=conditions.describe())
    for one in logs:
        one.end(report)
    return report


@contextmanager
def _conditions(
    real_time: bool | RealTime, announce: Callable[[LoopConditions], None] | None
) -> Iterator[LoopConditions | None]:
    if not real_time:
        yield None
        return
    with punctual(real_time if isinstance(real_time, RealTime) else RealTime()) as conditions:
        (announce or _say)(conditions)
        yield conditions


def _say(conditions: LoopConditions) -> None:
    print(conditions.describe(), file=sys.stderr)


def _truth(plant: Plant) -> State | None:
    method = getattr(plant, "ground_truth", None)
    return None if method is None else method()
