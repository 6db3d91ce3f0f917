"""`wbc trials`: grids of disturbed closed-loop runs, and their results."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import Annotated, Literal

from wbc.cli.argument_types import Argument, positive_number
from wbc.cli.exit_code import ExitCode
from wbc.cli.output import writing_results
from wbc.cli.outputs import OutputOptions, RunOutputs
from wbc.cli.parser import Function, Parser, set_commands
from wbc.cli.progress import ProgressLine
from wbc.cli.tour import tour
from wbc.cli.trials_run import run
from wbc.cli.trials_tables import (
    change_table,
    comparison_table,
    falls_table,
    results_text,
    verdict,
)
from wbc.cli.trials_tune import tune
from wbc.trials.comparison import compare as compare_results
from wbc.trials.plots import plot_results
from wbc.trials.provenance import Provenance
from wbc.trials.replay import find_trial, replay_trial
from wbc.trials.results import read_results
from wbc.trials.simulation import make_loop

#: The verb that runs when the first argument is none.
DEFAULT_VERB = "run"

_DESCRIPTION = """\
Run grids of trials: robots are pushed at many phases of their gait, from many directions, with
noisy sensors and the estimator in the loop, on all cores or on a Dask cluster.

  wbc trials GRID.toml            run a grid, or go on with it; short for  wbc trials run
  wbc trials show GRID.parquet    print its results again
  wbc trials replay GRID.parquet TRIAL --html FILE
                                  run one of its trials again, to see why the robot fell
  wbc trials plot GRID.parquet    draw the push map and the survival rates
  wbc trials compare A.parquet B.parquet
                                  compare two results trial by trial, with a verdict
  wbc trials tune GRID.toml --parameters FILE --budget 30
                                  search the parameters that survive most
  wbc trials tour                 walk to places under punches, beside published policies
"""


def show(
    results: Path,
    *,
    rates: bool = False,
    falls: Annotated[int | None, Argument("N", positive_number)] = None,
) -> None:
    """Print the results of a grid.

    Args:
        results: Parquet file that `wbc trials` has written.
        rates: print survival rates with their confidence intervals too.
        falls: print the N falls with the smallest disturbances, for wbc trials replay.
    """
    found = read_results(results)
    print(results_text(found, rates))
    if falls is not None:
        print(f"\n{falls_table(found, falls)}")


def replay(results: Path, trial: str, outputs: OutputOptions) -> ExitCode:
    """Run one trial of a grid again, from its beginning, to log or to show it.

    Args:
        results: Parquet file that `wbc trials` has written.
        trial: the trial, as wbc trials show --falls calls it.
        outputs: files to write.
    """
    earlier = read_results(results)
    found = find_trial(earlier, trial)
    differences = earlier.provenance.differences(Provenance.current())
    if differences:
        print(
            f"wbc: {results} is of other software ({', '.join(differences)}): the trial may end "
            "differently now",
            file=sys.stderr,
        )
    loop = make_loop(found.run)
    boxes = loop.plant.terrain.boxes()
    files = RunOutputs(outputs, loop.robot, boxes)
    with ProgressLine() as line, contextlib.ExitStack() as stack:
        observers = files.open_observers(stack)
        report = replay_trial(found, loop, observers=observers, progress=line.show_run)
    print(report.table())
    files.write(report)
    return ExitCode.SUCCESS if report.survived else ExitCode.FAILED


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


VERBS: dict[str, Function] = {
    "run": run,
    "show": show,
    "replay": replay,
    "plot": plot,
    "compare": compare,
    "tune": tune,
    "tour": tour,
}


def add_verbs(parser: Parser) -> None:
    """Add the verbs."""
    parser.description = _DESCRIPTION
    set_commands(parser, VERBS)
