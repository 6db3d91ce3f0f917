"""Tasks: desired accelerations as linear rows `A v̇ = b`, weighted or exact."""

from wbc.tasks.com import ComTask
from wbc.tasks.frame import FrameTask, OrientationTask, PositionTask
from wbc.tasks.function import FunctionRows, FunctionTask
from wbc.tasks.joint_coupling import JointCouplingTask
from wbc.tasks.joint_torque import JointTorqueTask
from wbc.tasks.look_at import LookAtTask
from wbc.tasks.low_acceleration import LowAccelerationTask
from wbc.tasks.manipulability import ManipulabilityTask
from wbc.tasks.momentum import AngularMomentumTask
from wbc.tasks.motion import MotionTask, TaskReference
from wbc.tasks.posture import PostureTask
from wbc.tasks.relative_frame import RelativeFrameTask
from wbc.tasks.task import JointTask, Task
from wbc.tasks.task_collection import TaskCollection

__all__ = [
    "AngularMomentumTask",
    "ComTask",
    "FrameTask",
    "FunctionRows",
    "FunctionTask",
    "JointCouplingTask",
    "JointTask",
    "JointTorqueTask",
    "LookAtTask",
    "LowAccelerationTask",
    "ManipulabilityTask",
    "MotionTask",
    "OrientationTask",
    "PositionTask",
    "PostureTask",
    "RelativeFrameTask",
    "Task",
    "TaskCollection",
    "TaskReference",
]
