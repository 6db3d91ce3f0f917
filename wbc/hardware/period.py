"""The period of a robot's state messages, measured."""

from __future__ import annotations

from itertools import pairwise
from statistics import median

from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import Hardware

_READINGS = 50
_TIMEOUT = 5.0  # s, until the first reading
_RESOLUTION = 5e-4  # s
_SHORTEST = 0.002  # s, of control; a robot that reports more often is controlled at this period


def measured_period(hardware: Hardware) -> float:
    """Return the period at which to control a robot: the median one of its state messages, s.

    It is rounded to half a millisecond, and at least 2 ms.

    Raises:
        HardwareError: there is no robot, or its messages stop.
    """
    times: list[float] = []
    while len(times) < _READINGS:
        reading = hardware.receive(_TIMEOUT)
        if reading is None:
            raise HardwareError(
                f"no valid state message within {_TIMEOUT:g} s: check the cable, the "
                "network interface, and that the robot is on"
            )
        times.append(reading.measurement.time)
    period = median(later - earlier for earlier, later in pairwise(times))
    return max(round(period / _RESOLUTION) * _RESOLUTION, _SHORTEST)
