"""Made-up results of trials, without any physics."""

from __future__ import annotations

import numpy as np

from wbc.trials import Grid, Results, RobotCases
from wbc.trials.provenance import Provenance
from wbc.trials.recorder import RunOutcome
from wbc.trials.result import TrialResult

SIZES = (0.2, 0.4, 0.6, 0.8)
FALLEN = RunOutcome(False, 0.5, "made up")


def made_up(limit: float, spread: float = 0.05, draw: int = 0, **changes) -> Results:
    """Results of a robot that survives sizes up to a limit that differs from push to push."""
    grid = Grid((RobotCases("g1", (0.0, 0.3)),), SIZES, phases=4, seeds=(0, 1, 2), **changes)
    random, rows = np.random.default_rng(draw), []
    for run in grid.runs():
        rows.append(TrialResult.of_run(run, RunOutcome(), None))
        limits: dict[object, float] = {}
        for trial in grid.trials(run):
            push = (trial.phase, trial.direction)
            mine = limits.setdefault(push, limit + spread * random.standard_normal())
            outcome = RunOutcome() if trial.size <= mine else FALLEN
            rows.append(TrialResult.of_trial(trial, outcome, None))
    return Results(tuple(rows), grid, Provenance.current())
