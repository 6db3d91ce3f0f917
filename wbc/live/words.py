"""Numbers in a page's message, checked."""

from __future__ import annotations

from typing import Any

from wbc.errors import short_repr
from wbc.live.errors import BadRequest


def checked_number(name: str, value: Any, low: float, high: float) -> float:
    """A number within its bounds.

    Raises:
        BadRequest: it is none, or out of range.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadRequest(f"{name} is {short_repr(value)}; it is a number")
    # Compared as it is: a whole number may be too large for a float.
    if not low <= value <= high:
        raise BadRequest(f"{name} = {short_repr(value)} is out of range: {low:g} to {high:g}")
    return float(value)
