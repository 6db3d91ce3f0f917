"""Teleoperation: one stream of commands to a running robot, from a page, ROS 2 or a script."""

from wbc.teleop.acknowledgement import Acknowledgement, CommandOutcome, CommandRefused
from wbc.teleop.capabilities import Capabilities
from wbc.teleop.channel import ChannelConfig, CommandChannel, CommandClient
from wbc.teleop.command_handler import CommandHandler
from wbc.teleop.commands import (
    FrameTaskCommand,
    GainCommand,
    GaitParameterCommand,
    HandTargetCommand,
    JointCommand,
    KeepVelocityCommand,
    MotionCommand,
    PauseCommand,
    PullCommand,
    PushCommand,
    ResetCommand,
    SentCommand,
    StandCommand,
    StartSessionCommand,
    TeleopCommand,
    TimeScaleCommand,
    VelocityCommand,
)
from wbc.teleop.parameters import TunableParameter
from wbc.teleop.session import TeleopClient, run
from wbc.teleop.session_choices import SessionChoices

__all__ = [
    "Acknowledgement",
    "Capabilities",
    "ChannelConfig",
    "CommandChannel",
    "CommandClient",
    "CommandHandler",
    "CommandOutcome",
    "CommandRefused",
    "FrameTaskCommand",
    "GainCommand",
    "GaitParameterCommand",
    "HandTargetCommand",
    "JointCommand",
    "KeepVelocityCommand",
    "MotionCommand",
    "PauseCommand",
    "PullCommand",
    "PushCommand",
    "ResetCommand",
    "SentCommand",
    "SessionChoices",
    "StandCommand",
    "StartSessionCommand",
    "TeleopClient",
    "TeleopCommand",
    "TimeScaleCommand",
    "TunableParameter",
    "VelocityCommand",
    "run",
]
