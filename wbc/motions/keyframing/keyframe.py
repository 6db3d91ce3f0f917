"""Keyframes: values in SI units, and where they are written in their file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from wbc.errors import MotionError

#: Factors to SI units, by quantity.
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
}

#: Name of the CoM's offset from standing among the positions.
COM = "com"


class KeyframeError(MotionError):
    """A keyframe file cannot be used; the message begins with file, line and column."""

    def __init__(self, source: str, where: FilePosition, text: str) -> None:
        super().__init__(f"{source}:{where.line}:{where.column}: {text}")


@dataclass(frozen=True, slots=True)
class FilePosition:
    """A position in a file; both count from 1.

    Attributes:
        line: line number.
        column: column number.
    """

    line: int
    column: int


@dataclass(frozen=True, slots=True)
class FileValue:
    """A number from a file.

    Attributes:
        number: number in SI units.
        quantity: a key of `UNITS`.
        where: its position in the file.
    """

    number: float
    quantity: str
    where: FilePosition


@dataclass(frozen=True)
class Keyframe:
    """Targets at one time.

    Attributes:
        time: s.
        joints: joint name -> position, rad (m for a prismatic joint).
        places: frame name, or `com` -> x, y, z, m.
    """

    time: FileValue
    joints: dict[str, FileValue] = field(default_factory=dict)
    places: dict[str, tuple[FileValue, FileValue, FileValue]] = field(default_factory=dict)


def number(text: str, where: FilePosition, source: str) -> float:
    """Parse a finite number.

    Raises:
        KeyframeError: the text is none.
    """
    try:
        value = float(text.replace("_", "?"))  # Python alone accepts 1_000
    except ValueError:
        raise KeyframeError(source, where, f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise KeyframeError(source, where, f"'{text}' is not finite")
    return value


def scale(
    unit: str, quantities: tuple[str, ...], where: FilePosition, source: str
) -> tuple[str, float]:
    """Return quantity and factor of a unit.

    Raises:
        KeyframeError: it is not a unit of these quantities.
    """
    for quantity in quantities:
        if unit in UNITS[quantity]:
            return quantity, UNITS[quantity][unit]
    known = ", ".join(name for quantity in quantities for name in UNITS[quantity])
    raise KeyframeError(source, where, f"unit '{unit}' is not one of {known}")
