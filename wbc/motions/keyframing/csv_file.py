"""Keyframes in CSV.

A header line, then a line per keyframe; an empty cell leaves that column out of a keyframe; lines
that begin with # are comments. Commas separate the cells, which may be in double quotes. Every
column states its unit.

    time [s], left_elbow [deg], left_hand.x [m], left_hand.y [m], left_hand.z [m], com.z [cm]
    1.0,      60,               0.35,            0.25,            1.1,
    2.0,      20,               ,                ,                ,                -4
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from wbc.motions.keyframing.keyframe import (
    COM,
    FilePosition,
    FileValue,
    Keyframe,
    KeyframeError,
    number,
    scale,
)

_HEAD = re.compile(r"^(?P<name>[^\[\]]+?)\s*\[(?P<unit>[^\[\]]*)\]$")
_AXES = "xyz"


@dataclass(frozen=True, slots=True)
class _Column:
    """A column of a CSV file: time, a joint, or one axis of a position."""

    name: str
    axis: str
    quantity: str
    scale: float
    where: FilePosition


def from_csv(text: str, source: str) -> list[Keyframe]:
    """Return the keyframes of a CSV text.

    Raises:
        KeyframeError: with line and column.
    """
    lines = [
        (k, line)
        for k, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise KeyframeError(
            source, FilePosition(1, 1), "a header line and at least one keyframe are needed"
        )
    head = _cells(*lines[0])
    if (first := _HEAD.match(head[0][0])) is None or first["name"].strip() != "time":
        raise KeyframeError(
            source,
            head[0][1],
            f"the first column must be  time [s],  separated from the next by a comma; it is "
            f"'{head[0][0]}'",
        )
    columns = [_column(cell, where, source) for cell, where in head]
    if len(columns) < 2:
        raise KeyframeError(source, head[0][1], "there is no column besides the time")
    _check_columns(columns, source)
    return [_row(k, line, columns, source) for k, line in lines[1:]]


def _cells(number: int, line: str) -> list[tuple[str, FilePosition]]:
    cells, start = [], 0
    for piece in line.split(","):
        indent = len(piece) - len(piece.lstrip())
        cell = piece.strip()
        if len(cell) > 1 and cell[0] == cell[-1] == '"':
            cell = cell[1:-1].strip()
        cells.append((cell, FilePosition(number, start + indent + 1)))
        start += len(piece) + 1
    return cells


def _column(cell: str, where: FilePosition, source: str) -> _Column:
    if not cell:
        raise KeyframeError(source, where, "a column without a name: a comma too many?")
    match = _HEAD.match(cell)
    if match is None:
        raise KeyframeError(
            source, where, f"column '{cell}' must be a name and a unit, such as  left_elbow [deg]"
        )
    name, unit = match["name"].strip(), match["unit"].strip()
    place, dot, axis = name.rpartition(".")
    if name == "time":
        return _Column(name, "", *scale(unit, ("time",), where, source), where)
    if dot and axis in _AXES:
        return _Column(place, axis, *scale(unit, ("length",), where, source), where)
    return _Column(name, "", *scale(unit, ("angle", "length"), where, source), where)


def _check_columns(columns: list[_Column], source: str) -> None:
    seen: dict[tuple[str, str], _Column] = {}
    for column in columns:
        key = (column.name, column.axis)
        if key in seen:
            raise KeyframeError(source, column.where, "this column exists already")
        seen[key] = column
    for column in columns:
        missing = [a for a in _AXES if column.axis and (column.name, a) not in seen]
        if missing and column.name != COM:
            raise KeyframeError(
                source, column.where, f"'{column.name}' has no column '{column.name}.{missing[0]}'"
            )


def _row(k: int, line: str, columns: list[_Column], source: str) -> Keyframe:
    cells = _cells(k, line)
    if len(cells) != len(columns):
        at = cells[len(columns)][1] if len(cells) > len(columns) else FilePosition(k, len(line) + 1)
        raise KeyframeError(source, at, f"{len(cells)} cells where the header has {len(columns)}")
    joints: dict[str, FileValue] = {}
    parts: dict[str, dict[str, FileValue]] = {}
    time: FileValue | None = None
    for (cell, where), column in zip(cells, columns, strict=True):
        if not cell:
            if column.name == "time":
                raise KeyframeError(source, where, "a keyframe needs its time")
            continue
        value = FileValue(column.scale * number(cell, where, source), column.quantity, where)
        if column.name == "time":
            time = value
        elif column.axis:
            parts.setdefault(column.name, {})[column.axis] = value
        else:
            joints[column.name] = value
    assert time is not None
    places = {name: _place(name, part, source) for name, part in parts.items()}
    return Keyframe(time, joints, places)


def _place(
    name: str, part: dict[str, FileValue], source: str
) -> tuple[FileValue, FileValue, FileValue]:
    first = next(iter(part.values()))
    missing = [axis for axis in _AXES if axis not in part]
    if missing and name != COM:
        raise KeyframeError(
            source, first.where, f"'{name}' has no {missing[0]} here: give all three, or none"
        )
    x, y, z = (part.get(axis, FileValue(0.0, "length", first.where)) for axis in _AXES)
    return x, y, z
