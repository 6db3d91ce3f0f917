"""`wbc robots`: the robots that can be loaded by name, and the properties of a robot."""

from __future__ import annotations

import argparse
from typing import Any

import wbc
from wbc.cli.exit_codes import SUCCESS
from wbc.cli.formatting import output_width, paragraph, table, terminal_width
from wbc.cli.robot_options import add_model_options, load_arguments
from wbc.errors import WbcError
from wbc.robot import available, examples


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "robots",
        help="list the robots that can be loaded by name, or the properties of a robot",
        description="Lists the robots that can be loaded by name: which properties were derived "
        "from the model, and which the robot's data file states. With names or files, lists all "
        "properties of these robots and where they come from.",
    )
    parser.add_argument(
        "robots",
        nargs="*",
        metavar="ROBOT",
        help="name of a robot, or path of a URDF or robot data file",
    )
    add_model_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """List; return the exit code."""
    arguments = load_arguments(options)
    if options.robots:
        robots = (wbc.load(name, **arguments) for name in options.robots)
        print("\n\n".join(map(_properties, robots)))
        return SUCCESS
    if any(arguments.values()):
        raise WbcError("the options of the robot model need a ROBOT, a name or a file")
    rows, errors = [], []
    for name in available():
        try:
            rows.append(_row(name, wbc.load(name)))
        except WbcError as error:
            errors.append(f"{name}: {error}")
    head = ("robot", "dof", "mass", "feet", "derived", "stated")
    print(table(head, rows, right=(1, 2), width=terminal_width()))
    for text in errors:
        print(text)
    print(f"\n{paragraph('from example-robot-data: ' + ', '.join(examples()), 0, output_width())}")
    print("\nwbc robots NAME lists all properties of a robot.")
    return SUCCESS


def _row(name: str, robot: wbc.Robot) -> tuple[str, ...]:
    left = robot.soles[0]
    feet = f"{2000 * left.half_length:.0f} × {2000 * left.half_width:.0f} mm"
    derived, stated = (
        ", ".join(_merged([fact.name for fact in robot.facts if fact.origin == origin]))
        for origin in ("derived", "stated")
    )
    return (name, str(robot.na), f"{robot.mass:.1f} kg", feet, derived, stated)


def _merged(names: list[str]) -> list[str]:
    """Return the names of properties with `left foot` and `right foot` as `feet`, and so on."""
    merged = []
    for name in names:
        side, _, part = name.partition(" ")
        if side == "right" and f"left {part}" in names:
            continue
        if side == "left" and f"right {part}" in names:
            name = {"foot": "feet"}.get(part, part + "s")
        merged.append(name)
    return merged


def _properties(robot: wbc.Robot) -> str:
    lines = [f"{robot.name}: {robot.na} joints, {robot.mass:.1f} kg, {robot.urdf_path.name}"]
    rows = [(fact.name, fact.origin, fact.source, fact.value) for fact in robot.facts]
    lines.append(table(("property", "origin", "source", "value"), rows, width=terminal_width()))
    lines += [paragraph(str(finding), 0, output_width()) for finding in robot.findings]
    return "\n".join(lines)
