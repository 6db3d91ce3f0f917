"""`wbc ros2 walk`: a robot in MuJoCo that a ROS 2 system drives."""

from __future__ import annotations

import argparse
import contextlib
from typing import TYPE_CHECKING, Any

from wbc.cli import teleoperated
from wbc.cli.parser import number
from wbc.cli.ros2_options import add_verb, network
from wbc.cli.simulation import make_terrain

if TYPE_CHECKING:
    from wbc.ros.bridge import Bridge
    from wbc.runtime.protocols import Observer
    from wbc.teleop import CommandHandler


def add_to(verbs: Any) -> None:
    """Add the verb."""
    parser = add_verb(verbs, "walk", "simulate a robot that a ROS 2 system drives", _walk)
    parser.add_argument(
        "--rate",
        type=number,
        default=50.0,
        metavar="HZ",
        help="rate of /joint_states, 1 to 500 Hz; the node's parameter update_rate (default: 50)",
    )
    parser.add_argument("--view", action="store_true", help="show the robot in the browser")
    parser.add_argument(
        "--as-fast-as-possible", action="store_true", help="run faster than real time"
    )
    parser.add_argument(
        "--sim-time",
        action="store_true",
        help="stamp messages with the time of /clock, for nodes with use_sim_time; the node's "
        "parameter use_sim_time",
    )
    teleoperated.add_options(parser)


def _walk(options: argparse.Namespace) -> int:
    from wbc.ros.bridge import Bridge
    from wbc.view import Meshcat

    def connect(
        handler: CommandHandler, stack: contextlib.ExitStack
    ) -> tuple[Bridge, list[Observer]]:
        robot = handler.player.robot
        observers: list[Observer] = []
        if options.view:
            boxes = make_terrain(options).boxes()
            observers.append(stack.enter_context(Meshcat(robot, boxes=boxes)))
        bridge = stack.enter_context(
            Bridge(
                handler,
                network=network(options),
                update_rate=options.rate,
                use_sim_time=options.sim_time,
            )
        )
        print(
            f"[INFO] [wbc]: {robot.name} is ready; listening on /cmd_vel. Press Ctrl-C to stop.",
            flush=True,
        )
        return bridge, observers

    # The loop keeps the time, which need not be that of the wall clock.
    real_time = not options.as_fast_as_possible
    return teleoperated.run(options, connect, owns_clock=False, real_time=real_time)
