"""Conversion between seconds and the messages `Time` and `Duration`."""

from __future__ import annotations

import time
from typing import Any

from wbc.messages import message_type

_TIME = message_type("builtin_interfaces/msg/Time")
_DURATION = message_type("builtin_interfaces/msg/Duration")
_NS = 1_000_000_000  # per second


def stamp_now() -> Any:
    """Return the system time as `builtin_interfaces/msg/Time`."""
    seconds, nanoseconds = divmod(time.time_ns(), _NS)
    return _TIME(sec=seconds, nanosec=nanoseconds)


def stamp_from_seconds(seconds: float) -> Any:
    """Return a time, s since 1970 or since the start of a simulation, as `Time`."""
    whole, part = divmod(round(_NS * seconds), _NS)
    return _TIME(sec=whole, nanosec=part)


def duration_from_seconds(seconds: float) -> Any:
    """Return a duration, s, as `builtin_interfaces/msg/Duration`."""
    whole, part = divmod(round(_NS * seconds), _NS)
    return _DURATION(sec=whole, nanosec=part)


def to_seconds(message: Any) -> float:
    """Return the value of a `Time` or `Duration`, s."""
    return float(message.sec) + 1e-9 * float(message.nanosec)
