"""Checks of the numbers of commands."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.errors import short_repr
from wbc.teleop.acknowledgement import CommandRefused

_FAR = 1e4  # m, from the origin


def check_place(name: str, place: Any) -> None:
    """Refuse what are no three numbers of a position, m.

    Raises:
        CommandRefused: it is not.
    """
    if np.shape(place) != (3,):
        raise CommandRefused(f"{name} is {short_repr(place)}; it is (x, y, z) in m")
    for part in place:
        check_number(name, part, -_FAR, _FAR, "m")


def check_number(name: str, value: Any, low: float, high: float, unit: str = "") -> float:
    """Return a number if it is one and within its bounds.

    Raises:
        CommandRefused: it is not.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise CommandRefused(f"{name} is {short_repr(value)}; it is a number")
    # Compared before any conversion: an integer may be too large for a float.
    if not low <= value <= high:
        bounds = f"{low:g} to {high:g} {unit}".strip() if low < high else f"it can only be {low:g}"
        raise CommandRefused(f"{name} = {short_repr(value)} is out of range: {bounds}")
    return float(value)
