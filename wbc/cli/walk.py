"""`wbc walk`: a robot walks in MuJoCo, with a report."""

from __future__ import annotations

import argparse
from typing import Any

from wbc.cli import itinerary, simulation
from wbc.cli.parser import number

_DURATION = 10.0
_CAUTIOUS = 0.3  # m/s, and
_SHARE = 0.4  # of what the robot can: the default speed


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "walk",
        help="walk in MuJoCo, with a view in the browser and a report",
        description="A robot walks in MuJoCo under torque control, and a report says how. It "
        "stands for a second, walks, and stops in time to end standing.",
    )
    way = parser.add_mutually_exclusive_group()
    way.add_argument(
        "--velocity",
        nargs=3,
        type=number,
        metavar=("VX", "VY", "WZ"),
        help="forward and left in m/s, turning left in rad/s (default: forward at an easy pace)",
    )
    way.add_argument(
        "--tour",
        action="store_true",
        help="forward, a curve, sideways, a turn in place and backward, at the robot's own pace",
    )
    simulation.add_options(parser, f"{_DURATION:g}, for a tour {itinerary.TOUR_DURATION:g}")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Walk; returns the exit code."""
    run = simulation.Simulation(options)
    largest = run.walker.gait.max_velocity
    if options.tour:
        return run.run(itinerary.tour(largest), options.duration or itinerary.TOUR_DURATION)
    velocity = options.velocity or (min(_CAUTIOUS, _SHARE * largest[0]), 0.0, 0.0)
    duration = options.duration or _DURATION
    return run.run(itinerary.walk(tuple(velocity), duration), duration)
