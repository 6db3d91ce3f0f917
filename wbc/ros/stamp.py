"""Time stamps."""

from __future__ import annotations

import time
from typing import Any

from wbc.messages import message_type

_TIME = message_type("builtin_interfaces/msg/Time")
_DURATION = message_type("builtin_interfaces/msg/Duration")


def stamp_now() -> Any:
    """The system's time as `builtin_interfaces/Time`."""
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    return _TIME(sec=seconds, nanosec=nanoseconds)


def stamp_at(seconds: float) -> Any:
    """`builtin_interfaces/Time` of some s, since 1970 or the beginning of a simulation."""
    whole, part = divmod(round(1e9 * seconds), 1_000_000_000)
    return _TIME(sec=whole, nanosec=part)


def seconds_of(stamp: Any) -> float:
    """A `Time` or `Duration` in s."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def duration(seconds: float) -> Any:
    """`builtin_interfaces/Duration` of some s."""
    whole, part = divmod(round(1e9 * seconds), 1_000_000_000)
    return _DURATION(sec=whole, nanosec=part)
