"""One measurement in every period of a robot's clock."""

from __future__ import annotations

import math
from dataclasses import replace

from wbc.hardware.hardware import Hardware, Reading
from wbc.hardware.safety.limits import SafetyLimits
from wbc.hardware.safety.reading_monitor import ReadingMonitor
from wbc.measurement import Measurement

_WAITING = 256  # readings that may wait at the start; a robot that sends on and on sends newer ones
_CLOCK_DRIFT = 1e-4  # s per s by which the clocks may differ


class StateFault(Exception):
    """What is wrong with the states of a robot; its text says it."""


class StateStream:
    """The states of a robot, period by period of its clock.

    A message that was lost is replaced by an extrapolation, so that every period has one
    measurement; further messages that came meanwhile are worked off at once.

    Args:
        hardware: the robot.
        limits: the limits.

    Attributes:
        time: time of the last measurement by the robot's clock, s.
        last: the last measurement; None before the first one.
        lost: state messages that were replaced by extrapolations.
    """

    def __init__(self, hardware: Hardware, limits: SafetyLimits) -> None:
        self._hardware, self._limits, self._dt = hardware, limits, hardware.period
        self._monitor = ReadingMonitor(hardware.robot, limits)
        self._pending: Reading | None = None
        self._clock_offset = math.inf
        self.time = 0.0
        self.last: Measurement | None = None
        self.lost = 0

    def start(self, timeout: float) -> bool:
        """Wait for the robot, and drop what came before.

        Args:
            timeout: how long to wait, s.

        Returns:
            Whether there is a robot.
        """
        first = self._hardware.receive(timeout)
        if first is None:
            return False
        for _ in range(_WAITING):
            newer = self._hardware.receive(0.0)
            if newer is None:
                break
            first = newer
        self.time = first.measurement.time - self._dt
        self._pending = first
        return True

    def next(self) -> tuple[Measurement, bool]:
        """Wait for the measurement of the next period.

        Returns:
            The measurement, and whether it was read, not extrapolated.

        Raises:
            StateFault: no message comes, too many were lost, or a reading has a fault.
        """
        reading, periods = self._await_reading()
        if periods > 1:
            if periods * self._dt > self._limits.silence:
                raise StateFault(f"{periods - 1} state messages in a row were lost")
            assert self.last is not None
            self._pending = reading
            self.lost += 1
            self.time += self._dt
            self.last = self._extrapolated(self.last)
            return self.last, False
        self.time = reading.measurement.time
        fault = self._monitor.fault(reading)
        if fault:
            raise StateFault(fault)
        self.last = reading.measurement
        return self.last, True

    def _await_reading(self) -> tuple[Reading, int]:
        """Return the first reading of a later period, and how many periods later it is."""
        now, silence = self._hardware.now, self._limits.silence
        end = now() + silence
        reading, self._pending = self._pending, None
        while True:
            left = end - now()
            reading = reading or self._hardware.receive(max(left, 0.0))
            if reading is not None:
                periods = round((reading.measurement.time - self.time) / self._dt)
                if periods > 0:
                    return reading, periods
            if reading is None or left < 0.0:
                raise StateFault(f"no valid state message for {1e3 * silence:.0f} ms")
            reading = None  # another one of the last period

    def _extrapolated(self, m: Measurement) -> Measurement:
        position = m.joint_position + self._dt * m.joint_velocity
        return replace(m, time=self.time, joint_position=position)

    def delay(self) -> float:
        """Return how far this computer is behind the robot's clock, s."""
        offset = self._hardware.now() - self.time
        # The smallest offset is that of the fastest message; it follows the clocks' drift.
        self._clock_offset = min(offset, self._clock_offset + _CLOCK_DRIFT * self._dt)
        return offset - self._clock_offset
