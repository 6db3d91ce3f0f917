"""Limits: inequalities that the controller's solution holds exactly."""

from wbc.limits.acceleration import JointAccelerationLimit
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.barrier import BarrierLimit, BarrierRows
from wbc.limits.com_polygon import ComPolygonLimit
from wbc.limits.distance import DistanceLimit
from wbc.limits.frame_region import FrameBoxLimit, KeepOutLimit
from wbc.limits.jerk import JointJerkLimit
from wbc.limits.limit import Limit, LimitRows
from wbc.limits.limit_set import AnyLimit, LimitSet
from wbc.limits.obstacle import ObstacleLimit
from wbc.limits.position import JointPositionLimit
from wbc.limits.self_collision import SelfCollisionLimit
from wbc.limits.torque import TorqueLimit
from wbc.limits.velocity import JointVelocityLimit

__all__ = [
    "AccelerationBound",
    "AnyLimit",
    "BarrierLimit",
    "BarrierRows",
    "ComPolygonLimit",
    "DistanceLimit",
    "FrameBoxLimit",
    "JointAccelerationLimit",
    "JointJerkLimit",
    "JointPositionLimit",
    "JointVelocityLimit",
    "KeepOutLimit",
    "Limit",
    "LimitRows",
    "LimitSet",
    "ObstacleLimit",
    "SelfCollisionLimit",
    "TorqueLimit",
]
