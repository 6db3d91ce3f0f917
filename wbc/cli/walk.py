"""`wbc walk`: a robot walks in MuJoCo, with a report."""

from __future__ import annotations

import argparse
from typing import Any

from wbc.cli import simulation, velocity_schedule
from wbc.cli.parser import number

_DURATION = 10.0  # s
_DEFAULT_SPEED = 0.3  # m/s, but at most
_SPEED_FRACTION = 0.4  # of the maximum speed


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "walk",
        help="walk in MuJoCo, shown in the browser, with a report",
        description="Simulates a walking robot in MuJoCo under torque control and prints a report. "
        "The robot stands for a second, walks, and stops in time to end standing.",
    )
    commands = parser.add_mutually_exclusive_group()
    commands.add_argument(
        "--velocity",
        nargs=3,
        type=number,
        metavar=("VX", "VY", "WZ"),
        help="forward and left velocity, m/s, and turn to the left, rad/s (default: forward at a "
        "moderate speed)",
    )
    commands.add_argument(
        "--tour",
        action="store_true",
        help="walk forward, in a curve, sideways, turn in place, and walk backward",
    )
    simulation.add_options(parser, f"{_DURATION:g}; tour: {velocity_schedule.TOUR_DURATION:g}")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Walk; return the exit code."""
    run = simulation.SimulatedRun(options)
    max_velocity = run.walker.gait.max_velocity
    if options.tour:
        duration = options.duration or velocity_schedule.TOUR_DURATION
        return run.walk(velocity_schedule.tour(max_velocity), duration)
    default = (min(_DEFAULT_SPEED, _SPEED_FRACTION * max_velocity[0]), 0.0, 0.0)
    duration = options.duration or _DURATION
    velocity = tuple(options.velocity or default)
    return run.walk(velocity_schedule.walk(velocity, duration), duration)
