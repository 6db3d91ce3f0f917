"""`wbc ros2 walk`: a robot in MuJoCo that a ROS 2 system drives."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import wbc
from wbc import teleop
from wbc.cli.exit_codes import FAILED, INTERRUPTED, SUCCESS
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.parser import number, seconds
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_model_options, add_robot_option, load_arguments
from wbc.cli.ros2_options import add_verb, network
from wbc.cli.run_outputs import RunOutputs, add_output_options
from wbc.cli.simulation import MAX_TILE_EXTENT, add_terrain_options
from wbc.runtime.protocols import Observer
from wbc.sim import Flat, Mujoco, Tiles

_DURATION = 3600.0  # s


def add_to(verbs: Any) -> None:
    """Add the verb."""
    parser = add_verb(verbs, "walk", "simulate a robot that a ROS 2 system drives", _walk)
    add_robot_option(parser)
    parser.add_argument(
        "--rate",
        type=number,
        default=50.0,
        metavar="HZ",
        help="rate of /joint_states, 1 to 500 Hz; the node's parameter update_rate (default: 50)",
    )
    parser.add_argument(
        "--duration",
        type=seconds,
        default=_DURATION,
        metavar="S",
        help=f"duration, s (default: {_DURATION:g})",
    )
    add_terrain_options(parser)
    parser.add_argument("--view", action="store_true", help="show the robot in the browser")
    parser.add_argument(
        "--as-fast-as-possible", action="store_true", help="run faster than real time"
    )
    parser.add_argument(
        "--sim-time",
        action="store_true",
        help="stamp messages with the time of /clock, for nodes with use_sim_time; the parameter "
        "use_sim_time of the node",
    )
    add_output_options(parser)
    add_model_options(parser)


def _walk(options: argparse.Namespace) -> int:
    from wbc.motions import MotionPlayer
    from wbc.ros.bridge import Bridge

    with exit_on_interrupt():
        robot = wbc.load(options.robot, **load_arguments(options))
        player = MotionPlayer(robot)
        terrain = (
            Flat()
            if options.terrain == "flat"
            else Tiles(seed=options.seed, extent=MAX_TILE_EXTENT)
        )
        plant = Mujoco(robot, dt=player.dt, terrain=terrain, seed=options.seed)
        outputs = RunOutputs(options, robot, terrain.boxes())
    with contextlib.ExitStack() as stack:
        observers: list[Observer] = []
        if options.view:
            observers.append(stack.enter_context(wbc.view.Meshcat(robot, boxes=terrain.boxes())))
        # The loop keeps the time, which need not be that of the wall clock.
        handler = stack.enter_context(teleop.CommandHandler(player, plant, owns_clock=False))
        bridge = stack.enter_context(
            Bridge(
                handler,
                network=network(options),
                update_rate=options.rate,
                use_sim_time=options.sim_time,
            )
        )
        observers += outputs.open_observers(stack)
        print(
            f"[INFO] [wbc]: {robot.name} is ready; listening on /cmd_vel. Press Ctrl-C to stop.",
            flush=True,
        )
        line = ProgressLine()
        stack.callback(line.close)
        interrupted = stack.enter_context(graceful_interrupt())
        report = teleop.run(
            handler,
            options.duration,
            clients=[bridge],
            observers=observers,
            real_time=not options.as_fast_as_possible,
            stop=lambda: bool(interrupted),
            progress=line.show,
            message=line.print,
        )
    if report is not None:
        print(report.table())
    outputs.write()
    if interrupted:
        return INTERRUPTED
    return SUCCESS if report is not None and report.survived else FAILED
