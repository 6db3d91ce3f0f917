"""The interface of a robot outside this process, whose joints are servos."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.servo import ServoCommand


@dataclass(frozen=True, slots=True)
class Reading:
    """One state message of a robot.

    Attributes:
        measurement: sensor readings; its time is that of the robot's clock, s.
        tilt: angle of the base from the upright, as the robot itself estimates it, rad.
        stop_pressed: the operator presses the stop key of the remote control.
    """

    measurement: Measurement
    tilt: float
    stop_pressed: bool = False


def tilt_of(w: float, x: float, y: float, z: float) -> float:
    """Return the angle from the upright of an attitude quaternion of any length but 0, rad."""
    norm = w * w + x * x + y * y + z * z
    up = 1.0 - 2.0 * (x * x + y * y) / norm if norm > 0.0 else -1.0
    return math.acos(min(max(up, -1.0), 1.0))


@dataclass(slots=True)
class ConnectionState:
    """Counters of a connection to a robot.

    Attributes:
        received: valid state messages.
        corrupt: state messages with a wrong checksum or size, which were dropped.
        reordered: state messages that were older than one before them, which were dropped.
        sent: commands.
    """

    received: int = 0
    corrupt: int = 0
    reordered: int = 0
    sent: int = 0


class Hardware(Protocol):
    """A robot outside this process: `Plant`'s sibling, without a step that anybody may call.

    A loop runs it through `wbc.hardware.SafeHardware`, which is a plant.

    Attributes:
        robot: the model; measurements and commands are in its joint order.
        period: period of the state messages, s.
        connection: counters of the connection.
    """

    robot: Robot
    period: float
    connection: ConnectionState

    def now(self) -> float:
        """Return the time of the clock of this computer, s."""

    def receive(self, timeout: float) -> Reading | None:
        """Return the oldest reading that was not returned yet.

        Args:
            timeout: how long to wait for it, s.

        Returns:
            The reading; None if there was none in time.

        Raises:
            HardwareError: the robot is another one than `robot`.
        """

    def send(self, command: ServoCommand) -> None:
        """Send a command to the servos, without waiting."""

    def damp(self) -> None:
        """Emergency stop: have all joints damped, at once."""

    def close(self) -> None:
        """End the connection."""
