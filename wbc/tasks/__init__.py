"""Tasks: desired accelerations as linear rows `A v̇ = b`, weighted or exact."""

from wbc.tasks.com import ComTask
from wbc.tasks.frame import FrameTask, OrientationTask, PositionTask
from wbc.tasks.joint_torque import JointTorqueTask
from wbc.tasks.momentum import AngularMomentumTask
from wbc.tasks.motion import MotionTask, TaskReference
from wbc.tasks.posture import PostureTask
from wbc.tasks.task import JointTask, Task

__all__ = [
    "AngularMomentumTask",
    "ComTask",
    "FrameTask",
    "JointTask",
    "JointTorqueTask",
    "MotionTask",
    "OrientationTask",
    "PositionTask",
    "PostureTask",
    "Task",
    "TaskReference",
]
