"""`wbc trials run`: a grid of trials on this machine or a cluster."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from wbc.cli.argument_types import Argument, OutputFile, PolicyFolder, positive_number
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import graceful_interrupt
from wbc.cli.output import writing_results
from wbc.cli.progress import ProgressLine
from wbc.cli.trials_tables import results_text
from wbc.errors import JointNotFound
from wbc.robot import load
from wbc.trials.controllers import ControllerSpec
from wbc.trials.errors import ResultsError
from wbc.trials.grid import Grid
from wbc.trials.grid_file import read_grid
from wbc.trials.policy import PolicyError, load_policy
from wbc.trials.runner import GridProgress, run_grid
from wbc.trials.workers import Workers, dask_workers, local_workers


def run(
    grid: Path,
    *,
    output: OutputFile | None = None,
    workers: Annotated[int | None, Argument("N", positive_number)] = None,
    cluster: Annotated[str | None, Argument("ADDRESS")] = None,
    policy: PolicyFolder | None = None,
    restart: bool = False,
    rates: bool = False,
) -> ExitCode:
    """Run the trials of a grid that have no result yet, and print what was survived.

    Every finished trial is kept: Ctrl-C ends the run after the trials that have begun, and the same
    command goes on with what is left. Results do not depend on the number of workers.

    Args:
        grid: grid of trials, a TOML file; benchmarks/grids contains examples.
        output: Parquet file of the results (default: the grid's name with .parquet, here).
        workers: number of processes (default: one per core).
        cluster: address of a Dask scheduler whose workers run the trials, e.g. tcp://host:8786.
        policy: folder of a learned policy, which is run besides the controllers of the grid, with
            the robots whose joints it commands.
        restart: discard earlier results of the output.
        rates: print survival rates with their confidence intervals too.
    """
    declared = read_grid(grid)
    if policy is not None:
        declared = _with_policy(declared, policy)
    path = output or Path(f"{grid.stem}.parquet")
    pool = dask_workers(cluster) if cluster is not None else local_workers(workers)
    with graceful_interrupt() as received, ProgressLine(period=10.0) as line, pool as available:
        progress = _Progress(line, available, path)
        with writing_results(ResultsError):
            results = run_grid(
                declared,
                path,
                available,
                restart=restart,
                progress=progress.show,
                stopped=lambda: bool(received),
            )
        left = progress.total - len(results.rows)
        if left:
            line.print(f"stopped: {left} of {progress.total} are left; the same command goes on")
            return ExitCode(128 + received[0])
    print(results_text(results, rates))
    print(f"\n{path.resolve()}")
    return ExitCode.SUCCESS


def _with_policy(grid: Grid, folder: Path) -> Grid:
    """Add a policy to the controllers of a grid, for the robots that it is made for.

    Raises:
        PolicyError: it cannot be read, or is made for none of the robots.
    """
    spec = ControllerSpec.of_policy(folder)
    others = tuple(controller.name for controller in grid.controllers)
    robots, refused = [], []
    for cases in grid.robots:
        controllers = cases.controllers or others
        try:
            load_policy(load(cases.robot), folder=folder)
        except (PolicyError, JointNotFound) as error:
            refused.append(error)
        else:
            controllers = (*controllers, spec.name)
        robots.append(replace(cases, controllers=controllers))
    if len(refused) == len(robots):
        raise refused[0]
    for refusal in refused:
        print(f"without the policy: {refusal}", file=sys.stderr)
    return replace(grid, controllers=(*grid.controllers, spec), robots=tuple(robots))


class _Progress:
    """Shows how far a grid has got."""

    def __init__(self, line: ProgressLine, workers: Workers, path: Path) -> None:
        self._line, self._workers, self._path = line, workers, path
        self.total = 0

    def show(self, progress: GridProgress) -> None:
        """Show the progress."""
        if not self.total:
            self.total = progress.total
            left = progress.total - progress.finished
            self._line.print(
                f"{progress.finished} of {progress.total} results are in {self._path}; "
                f"{left} left, on {self._workers.name}"
            )
        share = progress.finished / progress.total
        text = f"{progress.finished}/{progress.total} ({share:.0%})"
        if progress.remaining is not None:
            text += f", {time_text(progress.remaining)} left"
        self._line.show(text, progress.elapsed)


def time_text(seconds: float) -> str:
    """Return a time that is left in words."""
    minutes = round(seconds / 60.0)
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 90 else f"{minutes / 60.0:.1f} h"
