"""Runs a grid of trials on workers, resumes it, and writes its results."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import closing
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from wbc.trials.errors import ResultsError, TrialError
from wbc.trials.grid import Grid
from wbc.trials.partial_results import PartialResults
from wbc.trials.provenance import Provenance
from wbc.trials.result import TrialResult
from wbc.trials.results import Results, import_pyarrow, in_grid_order, read_results
from wbc.trials.simulation import Fork, make_loop, simulate_run, simulate_trial
from wbc.trials.trial import Trial, UndisturbedRun
from wbc.trials.workers import Workers, run_task

_POLL = 0.2  # s between two looks at whether to stop
_AHEAD = 2  # tasks per worker that are handed out at a time


@dataclass(frozen=True, slots=True)
class GridProgress:
    """How far a grid has got.

    Attributes:
        finished: number of results that are on disk.
        total: number of results of the grid.
        elapsed: s since the beginning of this run.
        remaining: estimate of the time left, s; None as long as little has finished.
    """

    finished: int
    total: int
    elapsed: float
    remaining: float | None


def run_grid(
    grid: Grid,
    output: str | Path,
    workers: Workers,
    *,
    restart: bool = False,
    progress: Callable[[GridProgress], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Results:
    """Run the trials of a grid that are not in the output yet.

    Every finished trial is on disk at once, in a file beside the output; an interrupted run goes on
    where it ended. Results do not depend on the number of workers or their order.

    Args:
        grid: the grid.
        output: path of a Parquet file, complete or not yet existing.
        workers: see `local_workers` and `dask_workers`.
        restart: discard what is in the output.
        progress: called when a result is there.
        stopped: whether to end early: no further trial is begun.

    Returns:
        The results; some are missing if the run was stopped.

    Raises:
        TrialError: the grid asks for what a robot or controller cannot do, or a worker has died.
        ResultsError: results cannot be written, or the output has results of other software.
        MissingExtra: a package of the extra `trials` is not installed.
    """
    import_pyarrow()  # hours later would be too late
    output, provenance = Path(output), Provenance.current()
    partial_path = output.with_name(f"{output.name}.partial")
    total = sum(1 + sum(1 for _ in grid.trials(run)) for run in grid.runs())
    if restart:
        for path in (output, partial_path):
            path.unlink(missing_ok=True)
    finished = _read_earlier(output, provenance)
    with closing(PartialResults(partial_path, provenance, total)) as partial:
        finished |= partial.finished
        schedule = _Schedule(grid, finished)
        if schedule.unfinished:
            check_grid(grid)
        _run(schedule, workers, partial, total, progress, stopped)
        rows = in_grid_order(grid, [*finished.values(), *partial.finished.values()])
        results = Results(rows, grid, provenance)
    if len(results.rows) == total:
        results.write(output)
        partial_path.unlink()
    return results


def check_grid(grid: Grid) -> None:
    """Make every robot, controller, plant and velocity of a grid once.

    Raises:
        WbcError: one of them does not exist or cannot do what the grid asks of it.
    """
    condition, seed = grid.conditions[0], grid.seeds[0]
    for run in grid.runs():
        if run.seed == seed and run.condition == condition:
            loop = make_loop(run)
            frame = getattr(grid.disturbance, "frame", None)
            if frame is not None:
                loop.robot.frame_id(frame)
            close = getattr(loop.controller, "close", None)
            if close is not None:
                close()
            for other in grid.conditions[1:]:
                other.make_plant(loop.robot, loop.plant.dt, seed)


def _read_earlier(output: Path, provenance: Provenance) -> dict[str, TrialResult]:
    """Return the results of a complete file by key: the grid may have grown since."""
    if not output.exists():
        return {}
    earlier = read_results(output)
    differences = earlier.provenance.differences(provenance)
    if differences:
        raise ResultsError(
            f"{output} was computed with other software: {', '.join(differences)}; give another "
            "output, or --restart to discard its results"
        )
    return {row.key: row for row in earlier.rows}


class _Schedule:
    """What is left to do: runs first, and then the trials that are forked from them."""

    def __init__(self, grid: Grid, finished: Mapping[str, TrialResult]) -> None:
        self._runs: deque[tuple[UndisturbedRun, dict[Fraction, list[Trial]]]] = deque()
        self._trials: deque[tuple[Fork, Trial]] = deque()
        self.unfinished = 0
        self.finished = finished
        seen = set(finished)
        for run in grid.runs():
            by_phase: dict[Fraction, list[Trial]] = {}
            for trial in grid.trials(run):
                if trial.key not in seen:
                    seen.add(trial.key)
                    by_phase.setdefault(trial.phase, []).append(trial)
            if by_phase or run.key not in seen:
                self._runs.append((run, by_phase))
                self.unfinished += (run.key not in seen) + sum(map(len, by_phase.values()))
                seen.add(run.key)

    def next(self) -> tuple[Callable[..., Any], tuple[Any, ...], dict[Fraction, list[Trial]]]:
        """Return the function and arguments of the next task, and what can follow it."""
        if self._trials:
            return simulate_trial, self._trials.popleft(), {}
        run, by_phase = self._runs.popleft()
        return simulate_run, (run, tuple(sorted(by_phase))), by_phase

    def __bool__(self) -> bool:
        return bool(self._runs or self._trials)

    def fork(self, forks: Iterable[Fork], by_phase: Mapping[Fraction, list[Trial]]) -> None:
        """Add the trials that can go on from a run."""
        self._trials.extend((fork, trial) for fork in forks for trial in by_phase[fork.phase])


def _run(
    schedule: _Schedule,
    workers: Workers,
    partial: PartialResults,
    total: int,
    progress: Callable[[GridProgress], None],
    stopped: Callable[[], bool],
) -> None:
    pending: dict[Future[Any], dict[Fraction, list[Trial]]] = {}
    begin = time.monotonic()
    first: tuple[float, int] | None = None

    def show() -> None:
        nonlocal first
        elapsed, remaining = time.monotonic() - begin, None
        # The first results take longer: workers start, and runs come before their trials.
        if first is None and schedule.unfinished - left >= workers.count:
            first = elapsed, left
        elif first is not None and left < first[1]:
            remaining = (elapsed - first[0]) * left / (first[1] - left)
        progress(GridProgress(total - left, total, elapsed, remaining))

    left = schedule.unfinished
    show()
    try:
        while schedule or pending:
            stop = stopped()
            while schedule and not stop and len(pending) < _AHEAD * workers.count:
                function, arguments, by_phase = schedule.next()
                task = workers.executor.submit(run_task, partial.provenance, function, *arguments)
                pending[task] = by_phase
            if stop:
                for future in [future for future in pending if future.cancel()]:
                    del pending[future]
                if not pending:
                    return
            done = wait(pending, _POLL, FIRST_COMPLETED).done
            # What has failed ends the run: what was finished is stored before.
            for future in sorted(done, key=_failed):
                by_phase = pending.pop(future)
                outcome = future.result()
                row, forks = outcome if isinstance(outcome, tuple) else (outcome, ())
                if row.key not in schedule.finished:
                    partial.add(row)
                    left -= 1
                schedule.fork(forks, by_phase)
                show()
    except Exception as error:
        lost = isinstance(error, BrokenExecutor | CancelledError)
        if lost or type(error).__module__.startswith("distributed"):
            raise TrialError(
                f"a worker was lost ({type(error).__name__}), e.g. because memory ran out; run "
                "again to go on with what is left, with fewer workers"
            ) from error
        raise
    finally:
        for future in pending:
            future.cancel()


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None
