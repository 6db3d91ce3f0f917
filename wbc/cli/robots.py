"""`wbc robots`: the robots that can be loaded by name, and what is known about each."""

from __future__ import annotations

import argparse
from typing import Any

import wbc
from wbc.cli.text import paragraph, table
from wbc.errors import WbcError
from wbc.robot import available, examples

_WIDTH = 100


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "robots",
        help="list the robots that can be loaded by name",
        description="Lists the robots that can be loaded by name: what was derived from the "
        "model and what a data file states. With names, every fact about those.",
    )
    parser.add_argument("names", nargs="*", metavar="ROBOT", help="a name, a URDF or a data file")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """List; returns the exit code."""
    if options.names:
        print("\n\n".join(_facts(wbc.load(name)) for name in options.names))
        return 0
    rows, broken = [], []
    for name in available():
        try:
            rows.append(_row(wbc.load(name)))
        except WbcError as error:
            broken.append(f"{name}: {error}")
    head = ("robot", "dof", "mass", "feet", "derived", "stated")
    print(table(head, rows, right=(1, 2)))
    for text in broken:
        print(text)
    print(f"\n{paragraph('from example-robot-data: ' + ', '.join(examples()), 0, _WIDTH)}")
    print("\nwbc robots NAME tells every fact about one.")
    return 0


def _row(robot: wbc.Robot) -> tuple[str, ...]:
    left = robot.soles[0]
    feet = f"{2000 * left.half_length:.0f} × {2000 * left.half_width:.0f} mm"
    derived, stated = (
        ", ".join(_short([fact.name for fact in robot.facts if fact.origin == origin]))
        for origin in ("derived", "stated")
    )
    return (robot.name, str(robot.na), f"{robot.mass:.1f} kg", feet, derived, stated)


def _short(names: list[str]) -> list[str]:
    """`left foot`, `right foot` as `feet`, and so on: the table must fit a screen."""
    short = []
    for name in names:
        side, _, part = name.partition(" ")
        if side == "right" and f"left {part}" in names:
            continue
        if side == "left" and f"right {part}" in names:
            name = {"foot": "feet"}.get(part, part + "s")
        short.append(name)
    return short


def _facts(robot: wbc.Robot) -> str:
    lines = [f"{robot.name}: {robot.na} joints, {robot.mass:.1f} kg, {robot.urdf_path.name}"]
    rows = [(fact.name, fact.origin, fact.source, fact.value) for fact in robot.facts]
    lines.append(table(("fact", "", "from", "value"), rows))
    lines += [paragraph(str(finding), 0, _WIDTH) for finding in robot.findings]
    return "\n".join(lines)
