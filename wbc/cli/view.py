"""`wbc view`: a robot in the browser, standing."""

from __future__ import annotations

import argparse
import time
from typing import Any

import wbc
from wbc.cli.parser import output, seconds
from wbc.cli.robot_options import add_robot_options, stated
from wbc.view import Meshcat, Recording, Snapshot


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "view",
        help="look at a robot in the browser",
        description="Shows a robot in its nominal posture in the browser, until Ctrl-C.",
    )
    parser.add_argument("robot", metavar="ROBOT", help="a name, a URDF or a robot data file")
    add_robot_options(parser)
    parser.add_argument(
        "--duration", type=seconds, metavar="S", help="end by itself after so many seconds"
    )
    parser.add_argument(
        "--html", type=output, metavar="FILE", help="write a page that opens offline, and end"
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Show; returns the exit code."""
    robot = wbc.load(options.robot, **stated(options))
    snapshot = _standing(robot)
    if options.html is not None:
        recording = Recording(robot)
        recording.show(snapshot)
        print(recording.save(options.html).resolve())
        return 0
    end = time.monotonic() + (options.duration or float("inf"))
    with Meshcat(robot) as viewer:
        print("Ctrl-C ends", flush=True)
        try:
            while viewer.alive and time.monotonic() < end:
                viewer.show(snapshot)
                time.sleep(min(0.2, max(end - time.monotonic(), 0.0)))
        except KeyboardInterrupt:
            print()
    return 0


def _standing(robot: wbc.Robot) -> Snapshot:
    state = robot.standing()
    com = wbc.Kinematics(robot, state).p_com.copy()
    return Snapshot(0.0, state.q, telemetry=wbc.Telemetry(com=com), text=robot.name)
