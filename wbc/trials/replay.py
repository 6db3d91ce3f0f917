"""Runs one trial of a grid again in the library's own loop, with observers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from wbc.runtime.loop import run
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.runtime.statistics import Progress
from wbc.trials.closed_loop import ClosedLoop
from wbc.trials.disturbance import apply_disturbance
from wbc.trials.errors import TrialError
from wbc.trials.results import Results
from wbc.trials.simulation import closing, disturbance_tick, make_loop, one_blas_thread
from wbc.trials.trial import Trial


def find_trial(results: Results, key: str) -> Trial:
    """Return the trial of a grid whose key begins like this.

    Raises:
        TrialError: there is none, or more than one.
    """
    grid = results.grid
    found = [t for r in grid.runs() for t in grid.trials(r) if t.key.startswith(key)]
    if len(found) != 1:
        what = "no trial" if not found else f"{len(found)} trials"
        raise TrialError(f"{what} of '{grid.name}' have a key that begins with '{key}'")
    return found[0]


def replay_trial(
    trial: Trial,
    loop: ClosedLoop | None = None,
    *,
    observers: Sequence[Observer] = (),
    progress: Callable[[Progress], None] | None = None,
) -> Report:
    """Run a trial from its beginning, warm-up included: tick by tick what the grid has run.

    The fall is found at most some ticks earlier than in the grid, which does not look at each.

    Args:
        trial: the trial.
        loop: its closed loop, at its beginning; made if left out.
        observers: log, recording, viewer.
        progress: see `wbc.run`.
    """
    with one_blas_thread(), closing(loop or make_loop(trial.run)) as one:
        plant, tick = one.plant, 0
        disturbed = disturbance_tick(trial.run, trial.phase, one)

        def before_tick(_: float) -> None:
            nonlocal tick
            if tick == disturbed:
                mass = one.robot.mass
                apply_disturbance(trial.disturbance, plant, trial.direction, trial.size, mass)
            tick += 1

        return run(
            one.controller,
            plant,
            disturbed * plant.dt + trial.duration,
            estimator=one.estimator,
            observers=observers,
            on_falling=lambda _: None,
            before_tick=before_tick,
            progress=progress,
        )
