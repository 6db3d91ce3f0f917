"""Tasks: what the robot should do, as rows in the acceleration."""

from wbc.tasks.com import ComTask
from wbc.tasks.frame import FrameTask, OrientationTask, PositionTask
from wbc.tasks.momentum import AngularMomentumTask
from wbc.tasks.posture import PostureTask
from wbc.tasks.task import Task

__all__ = [
    "AngularMomentumTask",
    "ComTask",
    "FrameTask",
    "OrientationTask",
    "PositionTask",
    "PostureTask",
    "Task",
]
