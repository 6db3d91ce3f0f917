"""What `wbc live` and `wbc ros2 walk` share: a robot in MuJoCo that is driven from outside."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable

import wbc
from wbc import teleop
from wbc.cli.exit_codes import FAILED, INTERRUPTED, SUCCESS
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt
from wbc.cli.parser import seconds
from wbc.cli.progress import ProgressLine
from wbc.cli.robot_options import add_model_options, add_robot_option, load_arguments
from wbc.cli.run_outputs import RunOutputs, add_output_options
from wbc.cli.simulation import add_solver_option, add_terrain_options, make_terrain
from wbc.motions import MotionPlayer
from wbc.runtime.protocols import Observer
from wbc.sim import Mujoco

_DURATION = 3600.0  # s

#: Opens the client that drives a robot, and possibly observers of the run, on a stack.
Connect = Callable[
    [teleop.CommandHandler, contextlib.ExitStack], tuple[teleop.TeleopClient, list[Observer]]
]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a teleoperated run."""
    add_robot_option(parser)
    parser.add_argument(
        "--duration",
        type=seconds,
        default=_DURATION,
        metavar="S",
        help=f"duration, s (default: {_DURATION:g})",
    )
    add_terrain_options(parser)
    add_solver_option(parser)
    add_output_options(parser)
    add_model_options(parser)


def run(
    options: argparse.Namespace,
    connect: Connect,
    *,
    owns_clock: bool = True,
    real_time: bool = True,
) -> int:
    """Simulate a robot until the duration is over or Ctrl-C; print the report, write the files.

    Args:
        options: parsed options, see `add_options`.
        connect: opens the client.
        owns_clock: see `wbc.teleop.CommandHandler`.
        real_time: see `wbc.teleop.run`.

    Returns:
        The exit code.

    Raises:
        WbcError: bad input, or a file cannot be written.
    """
    with exit_on_interrupt():
        robot = wbc.load(options.robot, **load_arguments(options))
        player = MotionPlayer(robot, walker=wbc.Walker(robot, solver=options.solver))
        terrain = make_terrain(options)
        plant = Mujoco(robot, dt=player.dt, terrain=terrain, seed=options.seed)
        outputs = RunOutputs(options, robot, terrain.boxes())
    with contextlib.ExitStack() as stack:
        handler = stack.enter_context(teleop.CommandHandler(player, plant, owns_clock=owns_clock))
        client, observers = connect(handler, stack)
        observers = [*observers, *outputs.open_observers(stack)]
        line = ProgressLine()
        stack.callback(line.close)
        interrupted = stack.enter_context(graceful_interrupt())
        report = teleop.run(
            handler,
            options.duration,
            clients=[client],
            observers=observers,
            real_time=real_time,
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
