"""Simulates undisturbed runs and the trials that are forked from them, in any process."""

from __future__ import annotations

import contextlib
import functools
import math
import pickle
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import wbc
from wbc.closeable import Closeable
from wbc.errors import MissingExtra
from wbc.robot import Robot
from wbc.trials.closed_loop import ClosedLoop
from wbc.trials.disturbance import apply_disturbance
from wbc.trials.errors import TrialError
from wbc.trials.recorder import Recorder, RunOutcome
from wbc.trials.result import TrialResult
from wbc.trials.trial import Trial, UndisturbedRun

DT = 0.002  # s, control period of all trials
_STANDING = 1.0  # s of standing, or of the first steps, that belong to the warm-up
_WARM_UP_CYCLES = 2  # gait cycles until a walk is steady
_MEASURED = 4.0  # s over which the figures of an undisturbed run are taken, at least
#: What pickling raises for objects that cannot be pickled.
_NOT_PICKLABLE = (pickle.PicklingError, TypeError, AttributeError, NotImplementedError)


@dataclass(frozen=True)
class Fork:
    """An undisturbed run at one phase, from which trials go on.

    Attributes:
        run: the undisturbed run.
        phase: share of a gait cycle after the warm-up.
        snapshot: the pickled closed loop; None if it cannot be pickled: trials repeat the run.
        failure: why there is nothing to go on from, if the run fell before.
    """

    run: UndisturbedRun
    phase: Fraction
    snapshot: bytes | None
    failure: RunOutcome | None = None


def make_loop(run: UndisturbedRun) -> ClosedLoop:
    """Return the closed loop of a run, standing, with its velocity commanded.

    Raises:
        TrialError: the controller cannot walk at that velocity.
        WbcError: robot, controller or plant cannot be made.
    """
    robot = _load(run.robot)
    plant = run.condition.make_plant(robot, DT, run.seed)
    estimator = run.condition.make_estimator(robot, DT)
    controller = run.controller.resolve()(robot, DT)
    loop = ClosedLoop(robot, plant, estimator, controller)
    loop.reset()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        controller.velocity = run.velocity
    if not all(math.isclose(*pair) for pair in zip(controller.velocity, run.velocity, strict=True)):
        wanted, got = (
            ", ".join(f"{x:.3g}" for x in v) for v in (run.velocity, controller.velocity)
        )
        raise TrialError(
            f"controller '{run.controller.name}' takes the velocity ({wanted}) on '{run.robot}' as "
            f"({got}); command what it can do"
        )
    return loop


def simulate_run(
    run: UndisturbedRun, phases: tuple[Fraction, ...]
) -> tuple[TrialResult, list[Fork]]:
    """Simulate an undisturbed run.

    After a second and two gait cycles of warm-up the run is saved at each phase of the next
    cycle; figures are taken over whole cycles after the warm-up.

    Args:
        run: the run.
        phases: shares of the gait cycle after the warm-up at which it is forked, increasing.

    Returns:
        Its result, and a fork for each phase.
    """
    with one_blas_thread(), closing(make_loop(run)) as loop:
        recorder = Recorder(loop)
        cycle = loop.controller.gait_cycle
        warm_up = _warm_up(run, loop)
        outcome = recorder.run(warm_up)
        if not outcome.survived:
            forks = [Fork(run, phase, None, outcome) for phase in phases]
            return TrialResult.of_run(run, outcome, recorder.metrics()), forks
        cycles = max(1, math.ceil(_MEASURED / cycle))
        snapshots: list[bytes | None] = []
        stops = [_ticks(float(phase) * cycle) for phase in phases]

        def save(tick: int) -> None:
            snapshots.extend(_pickled(loop) for stop in stops if stop == tick)

        outcome = recorder.run(cycles * cycle, save)
        reached = len(snapshots)
        saved = zip(phases[:reached], snapshots, strict=True)
        forks = [Fork(run, phase, snapshot) for phase, snapshot in saved]
        forks += [Fork(run, phase, None, outcome) for phase in phases[reached:]]
        if outcome.fell_at_s is not None:
            outcome = RunOutcome(
                False, warm_up + outcome.fell_at_s, outcome.reason, outcome.crashed
            )
        return TrialResult.of_run(run, outcome, recorder.metrics()), forks


def simulate_trial(fork: Fork, trial: Trial) -> TrialResult:
    """Simulate a trial from a fork of its undisturbed run.

    Args:
        fork: the undisturbed run at the trial's phase.
        trial: the trial.
    """
    if fork.failure is not None:
        reason = f"the undisturbed run ended: {fork.failure.reason}"
        outcome = RunOutcome(False, 0.0, reason, fork.failure.crashed)
        return TrialResult.of_trial(trial, outcome, None)
    with one_blas_thread(), closing(_restore(fork)) as loop:
        recorder = Recorder(loop)
        mass = loop.robot.mass
        apply_disturbance(trial.disturbance, loop.plant, trial.direction, trial.size, mass)
        outcome = recorder.run(trial.duration)
        return TrialResult.of_trial(trial, outcome, recorder.metrics())


def _restore(fork: Fork) -> ClosedLoop:
    if fork.snapshot is not None:
        loop: ClosedLoop = pickle.loads(fork.snapshot)
        return loop
    loop = make_loop(fork.run)
    for _ in range(disturbance_tick(fork.run, fork.phase, loop)):
        loop.tick()
    return loop


def disturbance_tick(run: UndisturbedRun, phase: Fraction, loop: ClosedLoop) -> int:
    """Return the number of ticks from the beginning of a run to a phase.

    Args:
        run: the run.
        phase: share of a gait cycle after the warm-up.
        loop: its closed loop.
    """
    return _ticks(_warm_up(run, loop)) + _ticks(float(phase) * loop.controller.gait_cycle)


def _warm_up(run: UndisturbedRun, loop: ClosedLoop) -> float:
    cycles = 0 if run.stands else _WARM_UP_CYCLES
    return _STANDING + cycles * loop.controller.gait_cycle


def _ticks(time: float) -> int:
    return round(time / DT)


def _pickled(loop: ClosedLoop) -> bytes | None:
    try:
        return pickle.dumps(loop, pickle.HIGHEST_PROTOCOL)
    except _NOT_PICKLABLE:
        return None


@functools.lru_cache(maxsize=16)
def _load(name: str) -> Robot:
    return wbc.load(name)


@contextlib.contextmanager
def closing(loop: ClosedLoop) -> Iterator[ClosedLoop]:
    """Close the controller of a loop at the end of the block, if it can be closed."""
    try:
        yield loop
    finally:
        if isinstance(loop.controller, Closeable):
            loop.controller.close()


def one_blas_thread() -> contextlib.AbstractContextManager[object]:
    """Limit BLAS to one thread: more only slow down small matrices, and change the last bits."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError as error:
        raise MissingExtra("threadpoolctl", "trials") from error
    limits: contextlib.AbstractContextManager[object] = threadpool_limits(1)
    return limits
