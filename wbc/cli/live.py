"""`wbc live`: a robot in MuJoCo, driven from the browser."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import wbc
from wbc import teleop
from wbc.cli.exit_codes import FAILED, INTERRUPTED, SUCCESS
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.parser import seconds
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_model_options, add_robot_option, load_arguments
from wbc.cli.run_outputs import RunOutputs, add_output_options
from wbc.cli.simulation import MAX_TILE_EXTENT, add_terrain_options
from wbc.motions import MotionPlayer
from wbc.sim import Flat, Mujoco, Tiles

_DURATION = 3600.0  # s


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "live",
        help="drive a robot in MuJoCo from the browser",
        description="Simulates a robot in MuJoCo under torque control and serves a web page that "
        "shows and drives it: velocity, motions, pushes, gait, gains, slow motion. It runs until "
        "Ctrl-C. --log records everything, --html and --video the time since the last reset.",
    )
    add_robot_option(parser)
    parser.add_argument(
        "--duration",
        type=seconds,
        default=_DURATION,
        metavar="S",
        help=f"duration, s (default: {_DURATION:g})",
    )
    add_terrain_options(parser)
    parser.add_argument(
        "--solver", metavar="NAME", help="QP solver (default: the solver of the library)"
    )
    parser.add_argument(
        "--port",
        type=_port,
        metavar="N",
        help="port of the page (default: the first free one from 7000 on)",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to listen on; anyone who can reach it can drive the robot (default: "
        "127.0.0.1, this machine only)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    add_output_options(parser)
    add_model_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run; return the exit code."""
    from wbc.live import Live

    with exit_on_interrupt():
        robot = wbc.load(options.robot, **load_arguments(options))
        player = MotionPlayer(robot, walker=wbc.Walker(robot, solver=options.solver))
        terrain = (
            Flat()
            if options.terrain == "flat"
            else Tiles(seed=options.seed, extent=MAX_TILE_EXTENT)
        )
        plant = Mujoco(robot, dt=player.dt, terrain=terrain, seed=options.seed)
        outputs = RunOutputs(options, robot, terrain.boxes())
    with contextlib.ExitStack() as stack:
        observers = outputs.open_observers(stack)
        handler = stack.enter_context(teleop.CommandHandler(player, plant))
        live = stack.enter_context(
            Live(handler, host=options.host, port=options.port, boxes=terrain.boxes())
        )
        if options.open:
            import webbrowser

            webbrowser.open(live.url)
        line = ProgressLine()
        stack.callback(line.close)
        interrupted = stack.enter_context(graceful_interrupt())
        report = teleop.run(
            handler,
            options.duration,
            clients=[live],
            observers=observers,
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


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) < 65536):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a port; use 0 to 65535, 0 for any free one"
        )
    return int(text)
