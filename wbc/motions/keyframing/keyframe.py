"""What keyframe files are about: values with units taken off, and where they are written."""

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

#: The name under which the CoM's offset from standing has a place.
COM = "com"


class KeyframeError(MotionError):
    """A keyframe file cannot be used; the text begins with file, line and column."""

    def __init__(self, source: str, where: FilePosition, text: str) -> None:
        super().__init__(f"{source}:{where.line}:{where.column}: {text}")


@dataclass(frozen=True, slots=True)
class FilePosition:
    """A place in a file; both count from 1."""

    line: int
    column: int


@dataclass(frozen=True, slots=True)
class FileValue:
    """A number of a file in SI units, its quantity (see `UNITS`), and where it is written."""

    number: float
    quantity: str
    where: FilePosition


@dataclass(frozen=True)
class Keyframe:
    """What is wanted at one time.

    Attributes:
        time: s.
        joints: joint name -> position, rad (m for a sliding joint).
        places: frame name, or `com` -> x, y, z, m.
    """

    time: FileValue
    joints: dict[str, FileValue] = field(default_factory=dict)
    places: dict[str, tuple[FileValue, FileValue, FileValue]] = field(default_factory=dict)


def number(text: str, where: FilePosition, source: str) -> float:
    """A finite number.

    Raises:
        KeyframeError: it is none.
    """
    try:
        value = float(text.replace("_", "?"))  # Python's 1_000 is nobody else's number
    except ValueError:
        raise KeyframeError(source, where, f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise KeyframeError(source, where, f"'{text}' is not finite")
    return value


def scale(
    unit: str, quantities: tuple[str, ...], where: FilePosition, source: str
) -> tuple[str, float]:
    """Quantity and factor of a unit.

    Raises:
        KeyframeError: it is no unit of these quantities.
    """
    for quantity in quantities:
        if unit in UNITS[quantity]:
            return quantity, UNITS[quantity][unit]
    known = ", ".join(name for quantity in quantities for name in UNITS[quantity])
    raise KeyframeError(source, where, f"unit '{unit}' is none of {known}")
