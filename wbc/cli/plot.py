"""`wbc plot`: the standard plots of a log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from wbc.cli.argument_types import Argument
from wbc.cli.logged_run import SpanOptions, read_run
from wbc.log import plots


def plot(
    log: Path,
    span: SpanOptions,
    *,
    out: Annotated[Path | None, Argument("FOLDER", Path)] = None,
    format: Literal["png", "pdf", "svg"] = "png",
    signal: Annotated[tuple[str, ...], Argument("NAME")] = (),
) -> None:
    """Plot balance, contact forces, torques, joints and tick times.

    CoM, DCM and ZMP are drawn with the footsteps, from above and over time; forces with the
    friction that they use; torques and velocities with their limits; joints with tracking and
    power.

    Args:
        log: path of a log, see --log of the other subcommands.
        span: part of the run.
        out: folder of the plots (default: the folder of the log).
        format: file format.
        signal: plot this quantity of the tick over time instead of the standard plots, e.g. tau
            or foot_wrench/left_sole.
    """
    run, folder = read_run(log, span.span()), out or log.parent
    for path in plots.plot(run, folder, f".{format}", signal):
        print(path.resolve())
