"""Whole-body kinematics and control of humanoids on Pinocchio.

Importing this brings only Pinocchio and numpy. Every name brings the rest of what it needs when it
is first used: `wbc.load` no controller, and only `wbc.sim` and `wbc.view` a simulator and a viewer.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import pinocchio  # noqa: F401  # everything needs it: paid here, where one expects to wait

if TYPE_CHECKING:
    from wbc import errors, log, motions, ros, sim, trials, view
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
    from wbc.measurement import Measurement
    from wbc.qp import Formulation
    from wbc.robot import Robot, load
    from wbc.runtime.loop import StopRun, run
    from wbc.runtime.loop_conditions import LoopConditions
    from wbc.runtime.real_time import RealTime
    from wbc.runtime.report import Report
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
    "LoopConditions",
    "Measurement",
    "OrientationTask",
    "PointContact",
    "PositionTask",
    "PostureTask",
    "RealTime",
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
    "log",
    "motions",
    "ros",
    "run",
    "sim",
    "trials",
    "view",
]

#: The room of each public name, and modules that are public themselves.
_NAMES = {
    "command": ("Command", "Status"),
    "contacts": ("Contact", "PointContact", "SurfaceContact"),
    "controller": ("WholeBodyController",),
    "errors": ("WbcError",),
    "estimation": ("Estimator", "GroundTruthEstimator"),
    "gait": ("GaitParameters",),
    "kinematics": ("Kinematics",),
    "limits": (
        "JointAccelerationLimit",
        "JointPositionLimit",
        "JointVelocityLimit",
        "TorqueLimit",
    ),
    "measurement": ("Measurement",),
    "qp": ("Formulation",),
    "robot": ("Robot", "load"),
    "runtime.loop": ("StopRun", "run"),
    "runtime.loop_conditions": ("LoopConditions",),
    "runtime.real_time": ("RealTime",),
    "runtime.report": ("Report",),
    "state": ("State",),
    "tasks": (
        "AngularMomentumTask",
        "ComTask",
        "FrameTask",
        "OrientationTask",
        "PositionTask",
        "PostureTask",
        "Task",
    ),
    "telemetry": ("Footstep", "Telemetry"),
    "walking": ("VelocityClamped", "Walker", "WalkerGains"),
}
_MODULES = ("errors", "log", "ros", "sim", "view", "motions", "trials")

if not TYPE_CHECKING:  # a checker is to report a name that is not there

    def __getattr__(name: str) -> Any:
        if name in _MODULES or name in _NAMES:
            return importlib.import_module(f"wbc.{name}")
        for module, names in _NAMES.items():
            if name in names:
                value = getattr(importlib.import_module(f"wbc.{module}"), name)
                globals()[name] = value
                return value
        raise AttributeError(f"module 'wbc' has no attribute '{name}'")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
