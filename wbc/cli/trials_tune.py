"""`wbc trials tune`: parameters of a controller, tuned over a grid."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from wbc.cli.argument_types import Argument, OutputFile, positive_number
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import graceful_interrupt
from wbc.cli.output import writing_results
from wbc.cli.progress import ProgressLine
from wbc.cli.trials_run import time_text
from wbc.trials.grid_file import read_grid, write_grid
from wbc.trials.runner import GridProgress
from wbc.trials.tuning import read_tuning_space
from wbc.trials.tuning import tune as tune_controller
from wbc.trials.workers import dask_workers, local_workers


def tune(
    grid: Path,
    *,
    parameters: Annotated[Path, Argument("FILE", Path)] = Path("parameters.toml"),
    budget: Annotated[int, Argument("N", positive_number)] = 30,
    output: OutputFile | None = None,
    workers: Annotated[int | None, Argument("N", positive_number)] = None,
    cluster: Annotated[str | None, Argument("ADDRESS")] = None,
) -> ExitCode:
    """Search the parameters of a controller that survive most trials of a grid.

    They are tuned on the seeds of the parameter file, which must not be the grid's. The result is a
    grid with the controller before and after, on seeds that the tuning has not seen. Sets whose
    undisturbed walk costs 5 % more than before do not count. The same command goes on with an
    interrupted search.

    Args:
        grid: grid of trials with one controller, a TOML file.
        parameters: TOML file of the seeds, and of low and high of each parameter.
        budget: number of parameter sets to run, the present one included.
        output: TOML file of the grid to write (default: the grid's name with _tuned, here); the
            results of each set are in a folder beside it.
        workers: number of processes (default: one per core).
        cluster: address of a Dask scheduler whose workers run the trials, e.g. tcp://host:8786.
    """
    declared, space = read_grid(grid), read_tuning_space(parameters)
    path = output or Path(f"{grid.stem}_tuned.toml")
    folder = path.with_suffix(".sets")
    pool = dask_workers(cluster) if cluster is not None else local_workers(workers)
    with graceful_interrupt() as received, ProgressLine(period=10.0) as line, pool as available:

        def show(number: int, progress: GridProgress) -> None:
            text = f"set {number + 1}/{budget}: {progress.finished}/{progress.total}"
            if progress.remaining is not None:
                text += f", {time_text(progress.remaining)} left"
            line.show(text, time.monotonic())

        result = tune_controller(
            declared,
            space,
            budget,
            folder,
            available,
            progress=show,
            stopped=lambda: bool(received),
        )
    for name, value in result.parameters.items():
        print(f"{name} = {value:.5g}")
    print(
        f"survived {100.0 * result.survived:.1f} % instead of {100.0 * result.survived_before:.1f} "
        f"% of the trials on the seeds of the tuning, after {result.evaluations} sets"
    )
    if not result.parameters:
        print("no set is better than the present parameters")
    else:
        before = declared.controllers[0]
        after = replace(result.controller, name=f"{before.name} tuned")
        with writing_results():
            write_grid(replace(declared, controllers=(before, after)), path)
        print(f"\n{path.resolve()}\nnow run it, and compare both on its own seeds:")
        print(f"  wbc trials {path}")
        files = f"{path.stem}.parquet {path.stem}.parquet"
        print(f"  wbc trials compare {files} --controllers '{before.name}' '{after.name}'")
    return ExitCode(128 + received[0]) if received else ExitCode.SUCCESS
