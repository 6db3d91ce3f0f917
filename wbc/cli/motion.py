"""`wbc motion`: a robot plays a motion in MuJoCo, with a report."""

from __future__ import annotations

import argparse
import inspect
import math

from wbc.cli.argument_types import Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.formatting import table
from wbc.cli.parser import Parser, set_command
from wbc.cli.scripted_run import RunOptions, ScriptedRun
from wbc.motions import Motion, MotionPlayer
from wbc.motions.registry import MOTIONS
from wbc.trials import MotionRunner, RunEvaluator

_MAX_DURATION = 300.0  # s


def add_verbs(parser: Parser) -> None:
    """Add a verb for each motion."""
    parser.description = (
        "Simulate a robot in MuJoCo that plays a motion, from standing to standing, under torque "
        "control, and print a report. `wbc motion NAME --help` prints the options of a motion."
    )
    parser.add_argument("--list", action="store_true", help="list the motions")
    parser.set_defaults(execute=_list)
    names = parser.add_subparsers(title="motions", metavar="NAME")
    for motion in MOTIONS:
        one = names.add_parser(motion.name, help=motion.summary)
        set_command(one, play, motion=motion)
        one.description = inspect.getdoc(motion)


def play(motion: Motion, run: RunOptions, *, duration: Seconds | None = None) -> ExitCode:
    """Play a motion in MuJoCo, and print a report.

    Args:
        motion: the motion.
        run: robot, ground and pushes.
        duration: duration, s (default: until the motion ends).
    """
    scripted = ScriptedRun(run, duration or _MAX_DURATION + 1.0)
    player = MotionPlayer(scripted.robot, motions=[motion], walker=scripted.biped_walker)
    return scripted.run(
        player,
        MotionRunner(player, duration or _MAX_DURATION),
        evaluator=RunEvaluator(),
        expected_duration=duration or math.inf,  # it ends with the motion
    )


def _list(_: argparse.Namespace) -> None:
    print(
        f"{table(('motion', 'description'), [(m.name, m.summary) for m in MOTIONS])}\n\n"
        "wbc motion NAME --robot ROBOT   play a motion: wbc motion squat --robot g1 --depth 15\n"
        "wbc motion NAME --help          print its options\n"
        "wbc robots                      list the robots"
    )
