"""Tunes parameters of a controller over a grid, on seeds that the grid itself does not use."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wbc.errors import MissingExtra, did_you_mean
from wbc.trials.controllers import ControllerSpec
from wbc.trials.errors import ResultsError, TrialError
from wbc.trials.grid import Grid
from wbc.trials.results import Results
from wbc.trials.runner import GridProgress, run_grid
from wbc.trials.toml_file import read_toml
from wbc.trials.workers import Workers

#: Undisturbed runs of tuned parameters may cost this much more than those of the first ones.
MAX_COST_RATIO = 1.05
_RANGE_KEYS = ("low", "high", "log")


@dataclass(frozen=True)
class ParameterRange:
    """The range of a parameter that is tuned.

    Attributes:
        path: option of the controller's factory, e.g. `("gains", "ankle_share")`.
        low: smallest value.
        high: greatest value.
        log: whether the logarithm is searched evenly.

    Raises:
        TrialError: an empty range, or a logarithmic one that is not positive.
    """

    path: tuple[str, ...]
    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise TrialError(f"parameter {self.name}: low = {self.low} must be below {self.high}")
        if self.log and self.low <= 0.0:
            raise TrialError(f"parameter {self.name}: a logarithmic range must be positive")

    @property
    def name(self) -> str:
        """The path with dots, e.g. "gains.ankle_share"."""
        return ".".join(self.path)


@dataclass(frozen=True)
class TuningSpace:
    """The parameters to tune, and the seeds to tune them on.

    Attributes:
        seeds: seeds of the tuning runs; none of the grid's.
        ranges: the parameters.
    """

    seeds: tuple[int, ...]
    ranges: tuple[ParameterRange, ...]

    def __post_init__(self) -> None:
        if not self.seeds or not self.ranges:
            raise TrialError("tuning needs at least one seed and one parameter")


@dataclass(frozen=True)
class TuningResult:
    """What was found.

    Attributes:
        parameters: the best values, by the name of the parameter.
        survived: share of the trials that survive with them, on the seeds of the tuning.
        survived_before: likewise with the parameters of the grid.
        controller: the grid's controller with the best values.
        evaluations: number of parameter sets that were evaluated.
    """

    parameters: Mapping[str, float]
    survived: float
    survived_before: float
    controller: ControllerSpec
    evaluations: int


def read_tuning_space(path: str | Path) -> TuningSpace:
    """Read the parameters to tune from a TOML file.

    `seeds = [100, 101]`, and a table for each option of the controller's factory, e.g.
    `[gains.ankle_share]` with `low`, `high` and, if it is searched logarithmically, `log = true`.

    Raises:
        TrialError: the file cannot be read, or a key or value is wrong.
    """
    content = read_toml(Path(path))
    seeds = content.pop("seeds", None)
    if not (isinstance(seeds, list) and all(type(seed) is int and seed >= 0 for seed in seeds)):
        raise TrialError(f"{path}: seeds must be a list of whole numbers, e.g. seeds = [100, 101]")
    try:
        return TuningSpace(tuple(seeds), tuple(_ranges(content, ())))
    except TrialError as error:
        raise TrialError(f"{path}: {error}") from error


def _ranges(table: Mapping[str, Any], path: tuple[str, ...]) -> list[ParameterRange]:
    if "low" in table or "high" in table:
        for key in table:
            if key not in _RANGE_KEYS:
                raise TrialError(f"unknown key '{'.'.join((*path, key))}'")
        low, high = table.get("low"), table.get("high")
        if not (isinstance(low, int | float) and isinstance(high, int | float)):
            raise TrialError(f"parameter {'.'.join(path)} needs two numbers, low and high")
        return [ParameterRange(path, float(low), float(high), bool(table.get("log", False)))]
    ranges: list[ParameterRange] = []
    for key, value in table.items():
        if not isinstance(value, Mapping):
            near = did_you_mean(key, (*_RANGE_KEYS, "seeds"))
            raise TrialError(f"'{'.'.join((*path, key))}' must be a table of low and high{near}")
        ranges += _ranges(value, (*path, key))
    return ranges


def tune(
    grid: Grid,
    space: TuningSpace,
    budget: int,
    folder: str | Path,
    workers: Workers,
    *,
    progress: Callable[[int, GridProgress], None] = lambda _number, _progress: None,
    stopped: Callable[[], bool] = lambda: False,
) -> TuningResult:
    """Search the parameters that survive most trials of a grid, on the seeds of the tuning.

    Optuna's tree-structured Parzen estimator proposes the values (Bergstra et al., NeurIPS 2011).
    The grid's own parameters are evaluated first. Sets whose undisturbed runs have a cost of
    transport more than `MAX_COST_RATIO` times that of the first do not count.

    Args:
        grid: with one controller; its seeds are not used.
        space: parameters and seeds.
        budget: number of parameter sets to evaluate, those of an interrupted search in the folder
            included.
        folder: folder of the results of each set; a search that was interrupted goes on there.
        workers: see `run_grid`.
        progress: called with the number of the set and the progress of its grid.
        stopped: whether to end early, with the best so far.

    Raises:
        TrialError: a seed of the tuning is one of the grid, the grid has several controllers, or
            nothing was evaluated.
        MissingExtra: `optuna` is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise MissingExtra("optuna", "trials") from error
    common = set(grid.seeds) & set(space.seeds)
    if common:
        raise TrialError(
            f"seed {min(common)} is one of the grid's: parameters that are tuned on a seed prove "
            "nothing on it; give the tuning seeds of its own"
        )
    if len(grid.controllers) != 1:
        raise TrialError(f"grid '{grid.name}' has {len(grid.controllers)} controllers; tune one")
    controller, folder = grid.controllers[0], Path(folder)
    tuned = replace(grid, seeds=space.seeds, name=f"{grid.name}: tuning")

    def evaluate(number: int, spec: ControllerSpec) -> Results:
        return run_grid(
            replace(tuned, controllers=(spec,)),
            folder / f"{number:04d}.parquet",
            workers,
            progress=lambda state: progress(number, state),
            stopped=stopped,
        )

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    sampler = optuna.samplers.TPESampler(seed=0, multivariate=True)
    study = optuna.create_study(direction="maximize", sampler=sampler)
    before = evaluate(0, controller)
    if stopped():
        raise TrialError("the tuning was stopped before its first result")
    reference = _cost(before)
    # Every set is proposed from the results of those before: what is on disk is not run again.
    for number in range(1, budget):
        trial = study.ask()
        values = {
            one.name: trial.suggest_float(one.name, one.low, one.high, log=one.log)
            for one in space.ranges
        }
        results = evaluate(number, with_options(controller, space, values))
        if stopped():
            break
        cost = _cost(results)
        if reference and (cost is None or cost > MAX_COST_RATIO * reference):
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
            continue
        study.tell(trial, _survived(results))
    found = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
    best = max(found, key=lambda trial: float(trial.value or 0.0), default=None)
    if best is None or float(best.value or 0.0) <= _survived(before):
        return TuningResult({}, _survived(before), _survived(before), controller, len(found) + 1)
    spec = with_options(controller, space, best.params)
    survived = float(best.value or 0.0)
    return TuningResult(dict(best.params), survived, _survived(before), spec, len(found) + 1)


def with_options(
    controller: ControllerSpec, space: TuningSpace, values: Mapping[str, float]
) -> ControllerSpec:
    """Return a controller with values of the parameters in its options."""
    options: dict[str, Any] = _copy(controller.options)
    for one in space.ranges:
        table = options
        for key in one.path[:-1]:
            table = table.setdefault(key, {})
        table[one.path[-1]] = values[one.name]
    return replace(controller, options=options)


def _copy(table: Mapping[str, Any]) -> dict[str, Any]:
    return {k: _copy(v) if isinstance(v, Mapping) else v for k, v in table.items()}


def _survived(results: Results) -> float:
    """Return the share of the trials that were survived."""
    if not results.trials:
        raise ResultsError("the grid has no trials")
    return sum(row.survived for row in results.trials) / len(results.trials)


def _cost(results: Results) -> float | None:
    """Return the mean cost of transport of the undisturbed walks; None without one."""
    if not all(row.survived for row in results.runs):
        return math.inf
    costs = [r.cost_of_transport for r in results.runs if r.cost_of_transport is not None]
    return sum(costs) / len(costs) if costs else None
