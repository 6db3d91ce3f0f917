"""`wbc ros2 walk`: a robot in MuJoCo that a ROS 2 system drives."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import wbc
from wbc.cli.interrupt import interruptible
from wbc.cli.keepsakes import Keepsakes, add_keepsake_options
from wbc.cli.parser import FELL, INTERRUPTED, number, seconds, seed
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_robot_options, stated
from wbc.cli.ros2_options import add_verb, network
from wbc.driving import drive
from wbc.sim import Flat, Mujoco, Tiles

_DURATION = 3600.0
_TILES = 12.0  # m


def add_to(verbs: Any) -> None:
    """Add the verb."""
    parser = add_verb(verbs, "walk", "a robot in MuJoCo that a ROS 2 system sees and drives", _walk)
    parser.add_argument(
        "--robot",
        default="talos",
        metavar="NAME|FILE",
        help="a robot's name, or a URDF or robot data file (default: talos)",
    )
    parser.add_argument(
        "--rate",
        type=number,
        default=50.0,
        metavar="HZ",
        help="of /joint_states, 1 to 500 Hz; the node's parameter update_rate (default: 50)",
    )
    parser.add_argument(
        "--duration", type=seconds, default=_DURATION, metavar="S", help="s (default: an hour)"
    )
    parser.add_argument("--terrain", choices=("flat", "tiles"), default="flat", help="see wbc walk")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="see wbc walk")
    parser.add_argument("--view", action="store_true", help="also show it in the browser")
    parser.add_argument(
        "--as-fast-as-possible", action="store_true", help="do not wait for the wall clock"
    )
    parser.add_argument(
        "--sim-time",
        action="store_true",
        help="stamp messages with the time of /clock, for nodes with use_sim_time; "
        "the node's parameter of that name",
    )
    add_keepsake_options(parser)
    add_robot_options(parser)


def _walk(options: argparse.Namespace) -> int:
    from wbc.motions import MotionPlayer
    from wbc.ros.bridge import Bridge

    robot = wbc.load(options.robot, **stated(options))
    player = MotionPlayer(robot)
    terrain = Flat() if options.terrain == "flat" else Tiles(seed=options.seed, extent=_TILES)
    plant = Mujoco(robot, dt=player.dt, terrain=terrain, seed=options.seed)
    keepsakes = Keepsakes(options, robot, terrain.boxes())
    with contextlib.ExitStack() as stack:
        viewer = None
        if options.view:
            viewer = stack.enter_context(wbc.view.Meshcat(robot, boxes=terrain.boxes()))
        bridge = stack.enter_context(
            Bridge(
                player,
                plant,
                network=network(options),
                update_rate=options.rate,
                use_sim_time=options.sim_time,
            )
        )
        logs = keepsakes.logs(stack)
        print(f"[INFO] [wbc]: {robot.name} stands at your /cmd_vel; Ctrl-C ends", flush=True)
        line = ProgressLine()
        stack.callback(line.close)
        interrupted = stack.enter_context(interruptible())
        report = drive(
            bridge,
            player,
            plant,
            options.duration,
            viewer=viewer,
            recording=keepsakes.recording,
            log=logs,
            real_time=not options.as_fast_as_possible,
            stop=lambda: bool(interrupted),
            progress=line.show,
            told=line.note,
        )
    if report is not None:
        print(report.table())
    keepsakes.finish()
    if interrupted:
        return INTERRUPTED
    return 0 if report is not None and report.survived else FELL
