"""The configuration of the log's process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class LogConfig:
    """Configuration of the log's process; it is pickled.

    Attributes:
        robot: the robot that is logged.
        path: of the file.
        status: file descriptor of the shared `LogStatus`.
        parent: process id of the parent, with which this process ends.
    """

    robot: Robot
    path: Path
    status: int
    parent: int
