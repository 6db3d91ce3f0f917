"""The loop: measure, estimate, control, act, in simulated or real time."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack

import numpy as np

from wbc.errors import PhysicsDiverged, WbcError
from wbc.estimation import Estimator, EstimatorNoise
from wbc.robot.fall import fall_reason
from wbc.runtime.clock import Clock
from wbc.runtime.event import FALL, FALLING, EventSource, RunEvent, tell
from wbc.runtime.loop_conditions import LoopConditions
from wbc.runtime.protocols import (
    Controller,
    GroundTruthSource,
    HasBacklash,
    HasPeriod,
    Observer,
    Plant,
    StateEstimator,
    StoppablePlant,
    StreamObserver,
    TelemetrySource,
)
from wbc.runtime.real_time import RealTime, garbage_collection_paused, real_time_thread
from wbc.runtime.report import Report
from wbc.runtime.schema import Quantity
from wbc.runtime.statistics import Progress, RunStatistics
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import NO_TELEMETRY, Tick

_PLAN_RATE = 30.0  # Hz of plant time, of the contact plan
_PROGRESS_PERIOD = 0.1  # s of plant time


class StopRun(Exception):
    """Raised in `before_tick` or `progress`: ends the run early, with the report so far."""


class RunComplete(StopRun):
    """Raised likewise when everything is done: the run ends early, as it should."""


def _print_falling(text: str) -> None:
    print(f"the robot is {text}", file=sys.stderr)


def _print_conditions(conditions: LoopConditions) -> None:
    print(conditions.describe(), file=sys.stderr)


def run(
    controller: Controller,
    plant: Plant,
    duration: float,
    *,
    estimator: StateEstimator | None = None,
    observers: Sequence[Observer] = (),
    quantities: Sequence[Quantity] = (),
    real_time: bool | RealTime = False,
    on_conditions: Callable[[LoopConditions], None] = _print_conditions,
    on_falling: Callable[[str], None] = _print_falling,
    before_tick: Callable[[float], None] | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Report:
    """Run a controller on a plant until the duration is over or the robot falls.

    Each control period: `plant.measure()` → `estimator.update` → `controller.step` →
    `plant.step`; then the observers see the tick. The run starts from where the plant is: a
    simulator from its last reset. However it ends, a `StoppablePlant` is stopped before anything
    else is done. The events of an `EventSource` are told to the observers.

    Args:
        controller: e.g. a `Walker`.
        plant: e.g. `wbc.sim.Mujoco`.
        duration: s of plant time.
        estimator: measurement to estimate; when left out, an `Estimator` that counts with the
            plant's backlash.
        observers: viewers, recordings, logs and the like; those with processes of their own read
            one stream of ticks in shared memory.
        quantities: further quantities of a tick, beside those of `wbc.runtime.quantities`.
        real_time: wait for the wall clock, so that a second takes a second. The loop asks the
            system for all that keeps its ticks on time, or for what a `RealTime` says, and gives
            it back at the end.
        on_conditions: called before the first tick of a real-time run with what was granted; by
            default a line is printed on standard error.
        on_falling: called when the controller finds a fall unavoidable, with its status text
            ("falling: …"); by default a line is printed on standard error.
        before_tick: called with the plant's time before each tick, to change commands or push.
        progress: called about ten times a second.
            Either of them may raise `StopRun` to end the run, or `RunComplete` when it is done.

    Raises:
        WbcError: the duration is not positive, the control periods of controller, estimator and
            plant differ, or the run was stopped before its first tick.
        PhysicsDiverged: in the first tick; later, the report says so.
    """
    if not duration > 0.0:
        raise WbcError(f"duration = {duration} s must be positive")
    estimator = estimator or _default_estimator(plant)
    for part in (controller, estimator):
        _check_period(part, plant)
    truth_source = plant if isinstance(plant, GroundTruthSource) else None
    true_state = truth_source.ground_truth() if truth_source is not None else None
    start = true_state or plant.robot.standing()
    estimator.reset(start)
    controller.reset(start)
    source = controller if isinstance(controller, TelemetrySource) else None
    stream = _stream_for(observers, plant, quantities)
    run_number = stream.begin_run() if stream is not None else 1
    for observer in observers:
        observer.begin(controller, plant)
    if isinstance(plant, EventSource):
        plant.emit = functools.partial(tell, observers)
    plan_every = max(1, round(1.0 / (_PLAN_RATE * plant.dt)))
    progress_every = max(1, round(_PROGRESS_PERIOD / plant.dt))
    end = plant.time + duration - 0.5 * plant.dt
    ticks = int(np.ceil(duration / plant.dt)) + 1
    clock: Clock | None = None
    conditions = ""
    with ExitStack() as stack:
        stack.enter_context(garbage_collection_paused())
        if real_time:
            wanted = real_time if isinstance(real_time, RealTime) else RealTime()
            granted = stack.enter_context(real_time_thread(wanted))
            on_conditions(granted)
            conditions = granted.describe()
            clock = Clock(plant.dt, ticks)
        if isinstance(plant, StoppablePlant):
            stack.callback(plant.stop)  # the last entry of the stack is the first to be left
        statistics = RunStatistics(plant.robot, start, plant.time, ticks)
        try:
            index = 0
            expected: np.ndarray | None = None
            ended = time.perf_counter()
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
                telemetry = source.telemetry if source is not None else NO_TELEMETRY
                plan = None
                if observers and source is not None and index % plan_every == 0:
                    plan = source.contact_plan
                before, ended = ended, time.perf_counter()
                tick = Tick(
                    now, measurement, estimate, command, true_state, t1 - t0, t2 - t1, telemetry,
                    plan, index, run_number, time.time(), ended - before,
                )  # fmt: skip
                true_state = truth_source.ground_truth() if truth_source is not None else None
                state = true_state or estimate.state
                if telemetry.phase == "falling" and not statistics.falling:
                    on_falling(telemetry.status_text)
                    tell(observers, RunEvent(now, FALLING, reason=telemetry.status_text))
                statistics.record(tick, state)
                if stream is not None:
                    stream.write(tick)
                for observer in observers:
                    observer.observe(tick)
                if progress is not None and index % progress_every == 0:
                    progress(statistics.progress(duration))
                reason = fall_reason(plant.robot, state, statistics.ground)
                if reason:
                    statistics.end(reason, fell_at=plant.time)
                    tell(observers, RunEvent(plant.time, FALL, reason=reason))
                    break
                index += 1
        except PhysicsDiverged as error:
            if statistics.empty:
                raise
            statistics.end(str(error), diverged=True)
            tell(observers, RunEvent(now, FALL, reason=str(error)))
        except StopRun as stop:
            if statistics.empty:
                raise WbcError(f"the run was stopped before its first tick: {stop}") from stop
            if not isinstance(stop, RunComplete):
                statistics.end(str(stop) or "stopped")
    report = statistics.report(clock, conditions)
    for observer in observers:
        observer.end(report)
    return report


def _default_estimator(plant: Plant) -> Estimator:
    backlash = plant.backlash if isinstance(plant, HasBacklash) else 0.0
    return Estimator(plant.robot, plant.dt, noise=EstimatorNoise(backlash=backlash))


def _check_period(part: object, plant: Plant) -> None:
    """Refuse a controller or estimator that is made for another control period."""
    if isinstance(part, HasPeriod) and abs(part.dt - plant.dt) > 1e-9 * plant.dt:
        name = type(part).__name__
        raise WbcError(
            f"{name}.dt = {part.dt} s differs from the plant's control period, {plant.dt} s; "
            f"make the {name} with dt={plant.dt}"
        )


def _stream_for(
    observers: Sequence[Observer], plant: Plant, quantities: Sequence[Quantity]
) -> TickStream | None:
    """Return the one stream that all stream observers read, that of their last run if it fits."""
    readers = [one for one in observers if isinstance(one, StreamObserver)]
    if not readers:
        return None
    wanted = tuple(dict.fromkeys((*quantities, *(q for one in readers for q in one.quantities))))
    stream = readers[0].stream
    if stream is None or stream.robot is not plant.robot or stream.quantities != wanted:
        stream = TickStream(plant.robot, wanted)
    for reader in readers:
        if reader.stream is not stream:
            reader.attach(stream)
    return stream
