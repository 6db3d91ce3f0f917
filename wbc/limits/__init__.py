"""Limits: what the robot's joints can bear."""

from wbc.limits.acceleration import JointAccelerationLimit
from wbc.limits.limit import AccelerationBound
from wbc.limits.position import JointPositionLimit
from wbc.limits.torque import TorqueLimit
from wbc.limits.velocity import JointVelocityLimit

__all__ = [
    "AccelerationBound",
    "JointAccelerationLimit",
    "JointPositionLimit",
    "JointVelocityLimit",
    "TorqueLimit",
]
