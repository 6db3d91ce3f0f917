"""`wbc trials`: grids of disturbed closed-loop runs, and their results."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from wbc.cli.argument_types import Argument, OutputFile, positive_number
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import graceful_interrupt
from wbc.cli.output import OutputError, writing_results
from wbc.cli.parser import Function, Parser, set_command
from wbc.cli.progress import ProgressLine
from wbc.cli.tour import tour
from wbc.cli.trials_tables import (
    change_table,
    comparison_table,
    rates_table,
    survival_table,
    undisturbed_table,
    verdict,
)
from wbc.trials.comparison import compare as compare_results
from wbc.trials.controllers import ControllerSpec
from wbc.trials.errors import ResultsError
from wbc.trials.grid_file import read_grid
from wbc.trials.plots import plot_results
from wbc.trials.results import Results, read_results
from wbc.trials.runner import GridProgress, run_grid
from wbc.trials.workers import Workers, dask_workers, local_workers

#: The verb that runs when the first argument is none.
DEFAULT_VERB = "run"

_DESCRIPTION = """\
Run grids of trials: robots are pushed at many phases of their gait, from many directions, with
noisy sensors and the estimator in the loop, on all cores or on a Dask cluster.

  wbc trials GRID.toml            run a grid, or go on with it; short for  wbc trials run
  wbc trials show GRID.parquet    print its results again
  wbc trials plot GRID.parquet    draw the push map and the survival rates
  wbc trials compare A.parquet B.parquet
                                  compare two results trial by trial, with a verdict
  wbc trials tour                 walk to places under punches, beside published policies
"""


def run(
    grid: Path,
    *,
    output: OutputFile | None = None,
    workers: Annotated[int | None, Argument("N", positive_number)] = None,
    cluster: Annotated[str | None, Argument("ADDRESS")] = None,
    policy: Path | None = None,
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
        policy: folder of a learned policy, which is run besides the controllers of the grid.
        restart: discard earlier results of the output.
        rates: print survival rates with their confidence intervals too.
    """
    declared = read_grid(grid)
    if policy is not None:
        spec = ControllerSpec("policy", "policy", {"folder": str(policy.expanduser().resolve())})
        declared = replace(declared, controllers=(*declared.controllers, spec))
    path = output or Path(f"{grid.stem}.parquet")
    pool = dask_workers(cluster) if cluster is not None else local_workers(workers)
    with _stop_on_signal() as received, ProgressLine(period=10.0) as line, pool as available:
        progress = _Progress(line, available, path)
        try:
            results = run_grid(
                declared,
                path,
                available,
                restart=restart,
                progress=progress.show,
                stopped=lambda: bool(received),
            )
        except ResultsError as error:
            raise OutputError(str(error)) from error
    if received:
        left = progress.total - len(results.rows)
        line.print(f"stopped: {left} of {progress.total} are left; the same command goes on")
        return ExitCode.INTERRUPTED
    _print(results, rates)
    print(f"\n{path.resolve()}")
    return ExitCode.SUCCESS


def show(results: Path, *, rates: bool = False) -> None:
    """Print the results of a grid.

    Args:
        results: Parquet file that `wbc trials` has written.
        rates: print survival rates with their confidence intervals too.
    """
    _print(read_results(results), rates)


def plot(
    results: Path,
    *,
    out: Annotated[Path | None, Argument("FOLDER", Path)] = None,
    format: Literal["png", "pdf", "svg"] = "png",
) -> None:
    """Draw the push map of a grid, and its survival rates over the size of the disturbance.

    Args:
        results: Parquet file that `wbc trials` has written.
        out: folder of the plots (default: the folder of the results).
        format: file format.
    """
    folder = out or results.parent
    with writing_results():
        paths = plot_results(read_results(results), folder, results.stem, f".{format}")
    for path in paths:
        print(path.resolve())


def compare(
    first: Path,
    second: Path,
    *,
    controllers: Annotated[tuple[str, str] | None, Argument(("A", "B"))] = None,
) -> ExitCode:
    """Compare two result files trial by trial, with a verdict on the second.

    Trials are paired by robot, velocity, condition, seed, phase, direction and size; and by the
    controller's name, unless each file has only one. The exit code is 1 if the second one is worse,
    on the whole or in any cell.

    Args:
        first: Parquet file that `wbc trials` has written, e.g. before a change.
        second: likewise, e.g. after the change; the same file to compare two of its controllers.
        controllers: compare controller A of the first file with B of the second.
    """
    before, after = read_results(first), read_results(second)
    if controllers is not None:
        before, after = before.of_controller(controllers[0]), after.of_controller(controllers[1])
    comparison = compare_results(before, after)
    names = controllers or (str(first), str(second))
    print(f"{' → '.join(names)}\n\n{comparison_table(comparison)}\n\n{verdict(comparison)}")
    print(f"\nundisturbed\n\n{change_table(before, after)}")
    return ExitCode.FAILED if comparison.any_worse else ExitCode.SUCCESS


def _print(results: Results, rates: bool) -> None:
    grid = results.grid
    print(
        f"{grid.name}: largest {grid.disturbance.kind}, {grid.disturbance.unit}, that is survived "
        f"in at least 95 % of {grid.phases} phases × {len(grid.seeds)} seeds, as all smaller ones "
        "are; + where it is the largest that was tried\n"
    )
    print(survival_table(results))
    if rates:
        print(f"\n{rates_table(results)}")
    print(f"\nundisturbed\n\n{undisturbed_table(results.runs)}")
    crashed = [row for row in results.trials if row.crashed]
    if crashed:
        print(f"\n{len(crashed)} trials ended with an error, e.g. {crashed[0].reason}")


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
            text += f", {_duration(progress.remaining)} left"
        self._line.show(text, progress.elapsed)


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60.0)
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 90 else f"{minutes / 60.0:.1f} h"


@contextlib.contextmanager
def _stop_on_signal() -> Iterator[list[int]]:
    """Yield a list that is not empty once Ctrl-C was pressed or SIGTERM came."""
    with graceful_interrupt() as received:
        previous = signal.signal(signal.SIGTERM, lambda number, _: received.append(number))
        try:
            yield received
        finally:
            signal.signal(signal.SIGTERM, previous)


VERBS: dict[str, Function] = {
    "run": run,
    "show": show,
    "plot": plot,
    "compare": compare,
    "tour": tour,
}


def add_verbs(parser: Parser) -> None:
    """Add the verbs."""
    parser.description = _DESCRIPTION
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for name, command in VERBS.items():
        summary = " ".join((command.__doc__ or "").partition(".\n")[0].split())
        set_command(verbs.add_parser(name, help=summary[:1].lower() + summary[1:]), command)
