"""`wbc live`: a robot in MuJoCo, driven from the browser."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import wbc
from wbc.cli.interrupt import interruptible
from wbc.cli.keepsakes import Keepsakes, add_keepsake_options
from wbc.cli.parser import FELL, INTERRUPTED, seconds, seed
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_robot_options, stated
from wbc.driving import drive
from wbc.motions import MotionPlayer
from wbc.sim import Flat, Mujoco, Tiles

_DURATION = 3600.0
_TILES = 12.0  # m


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "live",
        help="drive a robot in MuJoCo from the browser",
        description="A robot in MuJoCo under torque control, and a page that shows and drives it: "
        "velocity, motions, pushes, gait, gains, slow motion. It runs until Ctrl-C. A log keeps "
        "all of it, --html and --video the time since the last reset.",
    )
    parser.add_argument(
        "--robot",
        default="talos",
        metavar="NAME|FILE",
        help="a robot's name, or a URDF or robot data file (default: talos)",
    )
    parser.add_argument(
        "--duration", type=seconds, default=_DURATION, metavar="S", help="s (default: an hour)"
    )
    parser.add_argument("--terrain", choices=("flat", "tiles"), default="flat", help="see wbc walk")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="see wbc walk")
    parser.add_argument("--solver", metavar="NAME", help="see wbc walk")
    parser.add_argument(
        "--port", type=_port, metavar="N", help="of the page (default: the first free from 7000 on)"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="to listen on; whoever reaches it can drive the robot (default: this machine only)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    add_keepsake_options(parser)
    add_robot_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Drive; returns the exit code."""
    from wbc.live import Live

    robot = wbc.load(options.robot, **stated(options))
    player = MotionPlayer(robot, walker=wbc.Walker(robot, solver=options.solver))
    terrain = Flat() if options.terrain == "flat" else Tiles(seed=options.seed, extent=_TILES)
    plant = Mujoco(robot, dt=player.dt, terrain=terrain, seed=options.seed)
    keepsakes = Keepsakes(options, robot, terrain.boxes())
    with contextlib.ExitStack() as stack:
        logs = keepsakes.logs(stack)
        live = stack.enter_context(
            Live(player, plant, host=options.host, port=options.port, boxes=terrain.boxes())
        )
        if options.open:
            import webbrowser

            webbrowser.open(live.url)
        line = ProgressLine()
        stack.callback(line.close)
        interrupted = stack.enter_context(interruptible())
        report = drive(
            live,
            player,
            plant,
            options.duration,
            log=logs,
            recording=keepsakes.recording,
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


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"'{text}' is not a port: 0 to 65535, 0 for any")
    return int(text)
