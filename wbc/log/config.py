"""The configuration of the log writer's process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wbc.robot import Robot


@dataclass(frozen=True, eq=False)
class LogConfig:
    """The configuration of the log writer's process. It is sent there as a pickle.

    Attributes:
        robot: Robot whose run is logged.
        path: Path of the log file.
        status: File descriptor of the shared `LogStatus`.
        events: File descriptor of the queue of events.
    """

    robot: Robot
    path: Path
    status: int
    events: int
