"""`wbc motion`: a robot plays a motion in MuJoCo, with a report."""

from __future__ import annotations

import argparse
import inspect
import math
from typing import Any

from wbc.cli import simulation
from wbc.cli.formatting import table, terminal_width
from wbc.cli.parser import number
from wbc.motions import Motion, MotionPlayer
from wbc.motions.engine import MotionParameter
from wbc.motions.registry import MOTIONS
from wbc.trials import MotionRunner, RunEvaluator

_MAX_DURATION = 300.0  # s


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "motion",
        help="sway, squat, wave, reach and more in MuJoCo",
        description="Simulates a robot in MuJoCo that plays a motion, from standing to standing, "
        "under torque control, and prints a report. `wbc motion NAME --help` prints the options "
        "of a motion.",
    )
    parser.add_argument("--list", action="store_true", help="list the motions")
    parser.set_defaults(execute=execute, motion=None)
    names = parser.add_subparsers(title="motions", metavar="NAME")
    for motion in MOTIONS:
        one = names.add_parser(motion.name, help=motion.summary, description=inspect.getdoc(motion))
        group = one.add_argument_group("motion")
        for parameter in motion.parameters():
            _add_option(group, parameter)
        simulation.add_options(one, "until the motion ends")
        one.set_defaults(motion=motion)


def execute(options: argparse.Namespace) -> int:
    """Play; return the exit code."""
    motion: type[Motion] | None = options.motion
    if motion is None:
        print(_list_of_motions())
        return 0
    chosen = {p.name: getattr(options, _destination(p)) for p in motion.parameters()}
    run = simulation.SimulatedRun(options)
    player = MotionPlayer(run.robot, motions=[motion(**chosen)], walker=run.walker)
    runner = MotionRunner(player, options.duration or _MAX_DURATION)
    return run.run(
        player,
        options.duration or _MAX_DURATION + 1.0,
        runner,
        RunEvaluator(),
        expected_duration=options.duration or math.inf,  # it ends with the motion
    )


def _destination(parameter: MotionParameter) -> str:
    return f"motion_{parameter.name}"


def _option(parameter: MotionParameter) -> str:
    return "--" + parameter.name.replace("_", "-")


def _add_option(group: Any, parameter: MotionParameter) -> None:
    default = parameter.default
    settings: dict[str, Any] = {"dest": _destination(parameter), "default": default}
    if isinstance(default, bool):
        group.add_argument(
            _option(parameter), action="store_true", help=parameter.description, **settings
        )
        return
    shown = "" if default in (None, ()) else f" (default: {_text(default)})"
    settings["help"] = parameter.description.replace("%", "%%") + shown.replace("%", "%%")
    if parameter.choices:
        settings["choices"] = parameter.choices
    elif parameter.names:
        settings.update(nargs=len(parameter.names), metavar=parameter.names, type=number)
    elif isinstance(default, int):
        settings.update(type=int, metavar="N")
    elif isinstance(default, float):
        settings.update(type=number, metavar="X")
    else:
        settings["metavar"] = parameter.name.upper()
    group.add_argument(_option(parameter), **settings)


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(_text(v) for v in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _list_of_motions() -> str:
    rows = [(motion.name, motion.summary) for motion in MOTIONS]
    return (
        f"{table(('motion', 'description'), rows, width=terminal_width())}\n\n"
        "wbc motion NAME --robot ROBOT   play a motion: wbc motion squat --robot g1 --depth 15\n"
        "wbc motion NAME --help          print its options\n"
        "wbc robots                      list the robots"
    )
