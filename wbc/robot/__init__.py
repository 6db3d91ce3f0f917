"""Robots: the loader, the model with its soles and limits, and the model doctor."""

from wbc.robot.couplings import Coupling
from wbc.robot.doctor import check_file
from wbc.robot.finding import Fact, Finding
from wbc.robot.fixed_base import FixedBaseRobot, load_fixed_base
from wbc.robot.loader import load
from wbc.robot.registry import available, examples
from wbc.robot.robot import Robot, checked_robot
from wbc.robot.robot_model import RobotModel
from wbc.robot.soles import Sole

__all__ = [
    "Coupling",
    "Fact",
    "Finding",
    "FixedBaseRobot",
    "Robot",
    "RobotModel",
    "Sole",
    "available",
    "check_file",
    "checked_robot",
    "examples",
    "load",
    "load_fixed_base",
]
