"""The modes of a control loop."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """The mode of a control loop, as in the column `mode`."""

    RUNNING = 0
    PAUSED = 1
    FALLEN = 2  #: the robot fell, and the loop waits for a reset
