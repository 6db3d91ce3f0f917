"""`wbc plot`: the standard plots of a log."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from wbc.log.plots import KINDS, plot
from wbc.log.run import LoggedRun


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "plot",
        help="draw the standard plots of a log",
        description="Plots CoM, DCM and ZMP with the footsteps, from above and over time, the "
        "torques with their limits, and the tick times.",
    )
    parser.add_argument(
        "log", metavar="LOG", help="path of a log, see --log of the other subcommands"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help="folder of the plots (default: the folder of the log)",
    )
    parser.add_argument(
        "--format",
        choices=[kind[1:] for kind in KINDS],
        default="png",
        help="file format (default: png)",
    )
    parser.add_argument(
        "--signal",
        action="append",
        default=[],
        metavar="NAME",
        help="plot this quantity of the tick over time instead of the standard plots, e.g. tau or "
        "foot_wrench/left_sole; may be repeated",
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Plot; return the exit code."""
    folder = options.out if options.out is not None else Path(options.log).parent
    for path in plot(LoggedRun.read(options.log), folder, f".{options.format}", options.signal):
        print(path.resolve())
    return 0
