"""Limits: inequalities that the controller's solution holds exactly."""

from wbc.limits.acceleration import JointAccelerationLimit
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.barrier import BarrierLimit, BarrierRows
from wbc.limits.limit import Limit, LimitRows
from wbc.limits.limit_set import AnyLimit, LimitSet
from wbc.limits.position import JointPositionLimit
from wbc.limits.self_collision import SelfCollisionLimit
from wbc.limits.torque import TorqueLimit
from wbc.limits.velocity import JointVelocityLimit

__all__ = [
    "AccelerationBound",
    "AnyLimit",
    "BarrierLimit",
    "BarrierRows",
    "JointAccelerationLimit",
    "JointPositionLimit",
    "JointVelocityLimit",
    "Limit",
    "LimitRows",
    "LimitSet",
    "SelfCollisionLimit",
    "TorqueLimit",
]
