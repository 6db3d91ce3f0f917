"""`wbc robots`: the robots that can be loaded by name, and the properties of a robot."""

from __future__ import annotations

from typing import Annotated

import wbc
from wbc.cli.argument_types import Argument
from wbc.cli.formatting import paragraph, table
from wbc.cli.model_options import ModelOptions
from wbc.errors import WbcError
from wbc.robot import available, examples


def robots(robots: Annotated[tuple[str, ...], Argument("ROBOT")], model: ModelOptions) -> None:
    """List the robots that can be loaded by name, or the properties of a robot.

    The list states which properties were derived from the model, and which the robot's data file
    states. With names or files, all properties of these robots are listed, and where they come
    from.

    Args:
        robots: name of a robot, or path of a URDF or robot data file.
        model: properties of the robot.
    """
    if robots:
        print("\n\n".join(_properties(model.load(name)) for name in robots))
        return
    if model != ModelOptions():
        raise WbcError("the options of the robot model need a ROBOT, a name or a file")
    rows, errors = [], []
    for name in available():
        try:
            rows.append(_row(name, wbc.load(name)))
        except WbcError as error:
            errors.append(f"{name}: {error}")
    print(table(("robot", "dof", "mass", "feet", "derived", "stated"), rows, right=(1, 2)))
    print(*errors, sep="\n", end="\n" if errors else "")
    print(f"\n{paragraph('from example-robot-data: ' + ', '.join(examples()))}")
    print("\nwbc robots NAME lists all properties of a robot.")


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
    lines.append(table(("property", "origin", "source", "value"), rows))
    lines += [paragraph(str(finding)) for finding in robot.findings]
    return "\n".join(lines)
