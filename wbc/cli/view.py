"""`wbc view`: show a robot in the browser."""

from __future__ import annotations

import argparse
import time
from typing import Any

import wbc
from wbc.cli.exit_codes import SUCCESS
from wbc.cli.output import OutputError
from wbc.cli.parser import output_file, seconds
from wbc.cli.robot_options import add_model_options, load_arguments
from wbc.errors import WbcError
from wbc.view import Meshcat, Recording, Snapshot


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "view",
        help="show a robot in the browser",
        description="Shows a robot in its nominal posture in the browser, until Ctrl-C.",
    )
    parser.add_argument(
        "robot", metavar="ROBOT", help="name of a robot, or path of a URDF or robot data file"
    )
    add_model_options(parser)
    parser.add_argument("--duration", type=seconds, metavar="S", help="stop after S seconds")
    parser.add_argument(
        "--html", type=output_file, metavar="FILE", help="write a page that opens offline, and exit"
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Show the robot; return the exit code."""
    robot = wbc.load(options.robot, **load_arguments(options))
    snapshot = _standing_snapshot(robot)
    if options.html is not None:
        recording = Recording(robot)
        recording.show(snapshot)
        try:
            print(recording.save(options.html).resolve())
        except WbcError as error:
            raise OutputError(str(error)) from error
        return SUCCESS
    end = time.monotonic() + (options.duration or float("inf"))
    with Meshcat(robot) as viewer:
        print("Press Ctrl-C to stop.", flush=True)
        try:
            while viewer.alive and time.monotonic() < end:
                viewer.show(snapshot)
                time.sleep(min(0.2, max(end - time.monotonic(), 0.0)))
        except KeyboardInterrupt:
            print()
    return SUCCESS


def _standing_snapshot(robot: wbc.Robot) -> Snapshot:
    state = robot.standing()
    com = wbc.Kinematics(robot, state).p_com.copy()
    return Snapshot(0.0, state.q, telemetry=wbc.Telemetry(com=com), text=robot.name)
