"""`wbc stand`: a robot stands in MuJoCo, with a report."""

from __future__ import annotations

import argparse
from typing import Any

from wbc.cli import simulation
from wbc.cli.itinerary import Itinerary

_DURATION = 5.0


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "stand",
        help="stand in MuJoCo, perhaps against pushes",
        description="A robot stands in MuJoCo under torque control, and a report says how.",
    )
    simulation.add_options(parser, f"{_DURATION:g}")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Stand; returns the exit code."""
    return simulation.Simulation(options).run(Itinerary(()), options.duration or _DURATION)
