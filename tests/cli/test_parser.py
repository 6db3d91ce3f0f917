"""How functions become commands: what is parsed, and what the help shows."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from typing import Annotated, Literal

import pytest
from clitools import environment

from wbc.cli import diff, doctor, live, log, plot, replay, report, robots, ros2, stand, view, walk
from wbc.cli.argument_types import Argument, Seconds, number
from wbc.cli.parser import DeferredCommand, Parser, set_command

COMMANDS = [
    *(diff.diff, doctor.doctor, live.live, log.log, plot.plot, replay.replay, robots.robots),
    *(report.report, stand.stand, view.view, walk.walk),
    *(
        f.load() if isinstance(f, DeferredCommand) else f
        for verb in ros2.VERBS.values()
        for f in (verb.values() if isinstance(verb, dict) else [verb])
    ),
]


@dataclass(frozen=True)
class Ground:
    """The ground.

    Attributes:
        friction: coefficient of friction.
        kind: what the ground
            is made of.
    """

    friction: float = 0.5
    kind: Literal["flat", "tiles"] = "flat"


def command(
    name: str,
    ground: Ground,
    *,
    velocity: Annotated[tuple[float, float] | None, Argument(("VX", "VY"), number)] = None,
    duration: Seconds | None = None,
    signals: Annotated[tuple[str, ...], Argument("NAME", flag="--signal")] = (),
    fast: bool = False,
    view: bool = True,
) -> tuple[object, ...]:
    """Do something.

    Args:
        name: 100 % of the name.
        ground: the ground.
        velocity: velocity, m/s.
        duration: duration, s.
        signals: names.
        fast: run fast.
        view: show nothing.
    """
    return name, ground, velocity, duration, signals, fast, view


@pytest.fixture
def parser():
    parser = Parser(prog="test")
    set_command(parser, command)
    return parser


def run(parser, *arguments):
    parsed = parser.parse_args(arguments)
    return parsed.execute(parsed)


def test_omitted_arguments_have_the_defaults_of_the_function(parser):
    assert run(parser, "a") == ("a", Ground(), None, None, (), False, True)


def test_parameters_of_functions_and_dataclasses_are_arguments(parser):
    arguments = "--friction 0.7 --kind tiles --velocity -1 2 --duration 3 --signal b --signal c"
    assert run(parser, *arguments.split(), "--fast", "--no-view", "a") == (
        *("a", Ground(0.7, "tiles"), (-1.0, 2.0), 3.0, ("b", "c"), True, False),
    )


def test_the_help_shows_descriptions_and_defaults(parser):
    text = " ".join(parser.format_help().split())
    assert "Do something. positional arguments: NAME 100 % of the name" in text
    assert "--friction X coefficient of friction (default: 0.5)" in text
    assert "--kind {flat,tiles} what the ground is made of (default: flat)" in text
    assert "--signal NAME names; repeatable" in text
    assert "--no-view show nothing" in text


@pytest.mark.parametrize("function", COMMANDS, ids=lambda function: function.__name__)
def test_every_argument_of_every_command_is_described(function):
    parser = Parser()
    set_command(parser, function)
    assert parser.description
    assert all(action.help for action in parser._actions)


@pytest.mark.parametrize("command", ["--help", "ros2 topic list --help"])
def test_neither_help_nor_the_ros_graph_import_pinocchio(command):
    code = (
        f"import sys; from wbc.cli import main; main({command.split()}); "
        "print('pinocchio' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment()
    )
    assert done.stdout.splitlines()[-1] == "False"
