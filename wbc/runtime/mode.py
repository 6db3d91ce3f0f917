"""What a control loop is doing."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """What a control loop is doing, as the column `mode` has it."""

    RUNNING = 0
    PAUSED = 1
    FALLEN = 2  #: the robot fell, and the loop waits for a reset
