"""`wbc stand`: a robot stands in MuJoCo, with a report."""

from __future__ import annotations

import argparse
from typing import Any

from wbc.cli import simulation
from wbc.cli.velocity_schedule import VelocitySchedule

_DURATION = 5.0  # s


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "stand",
        help="stand in MuJoCo, with pushes if you like",
        description="Simulates a standing robot in MuJoCo under torque control and prints a "
        "report.",
    )
    simulation.add_options(parser, f"{_DURATION:g}")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Stand; return the exit code."""
    run = simulation.SimulatedRun(options)
    return run.walk(VelocitySchedule(()), options.duration or _DURATION)
