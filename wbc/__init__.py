"""Whole-body kinematics and control of humanoids on Pinocchio.

Importing this brings only Pinocchio and numpy. Simulator and viewer are imported when
`wbc.sim` or `wbc.view` is first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from wbc import errors
from wbc.command import Command, Status
from wbc.contacts import Contact, PointContact, SurfaceContact
from wbc.controller import WholeBodyController
from wbc.errors import WbcError
from wbc.estimation import Estimator, GroundTruthEstimator
from wbc.gait import GaitParameters
from wbc.kinematics import Kinematics
from wbc.limits import (
    JointAccelerationLimit,
    JointPositionLimit,
    JointVelocityLimit,
    TorqueLimit,
)
from wbc.loop import StopRun, run
from wbc.measurement import Measurement
from wbc.qp import Formulation
from wbc.report import Report
from wbc.robot import Robot, load
from wbc.state import State
from wbc.tasks import (
    AngularMomentumTask,
    ComTask,
    FrameTask,
    OrientationTask,
    PositionTask,
    PostureTask,
    Task,
)
from wbc.telemetry import Footstep, Telemetry
from wbc.walking import VelocityClamped, Walker, WalkerGains

if TYPE_CHECKING:
    from wbc import sim, view

__version__ = "0.1.0.dev0"

__all__ = [
    "AngularMomentumTask",
    "ComTask",
    "Command",
    "Contact",
    "Estimator",
    "Footstep",
    "Formulation",
    "FrameTask",
    "GaitParameters",
    "GroundTruthEstimator",
    "JointAccelerationLimit",
    "JointPositionLimit",
    "JointVelocityLimit",
    "Kinematics",
    "Measurement",
    "OrientationTask",
    "PointContact",
    "PositionTask",
    "PostureTask",
    "Report",
    "Robot",
    "State",
    "Status",
    "StopRun",
    "SurfaceContact",
    "Task",
    "Telemetry",
    "TorqueLimit",
    "VelocityClamped",
    "Walker",
    "WalkerGains",
    "WbcError",
    "WholeBodyController",
    "errors",
    "load",
    "run",
    "sim",
    "view",
]

_ON_DEMAND = ("sim", "view")


def __getattr__(name: str) -> Any:
    if name in _ON_DEMAND:
        return importlib.import_module(f"wbc.{name}")
    raise AttributeError(f"module 'wbc' has no attribute '{name}'")
