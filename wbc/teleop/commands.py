"""The commands that a running robot takes from any sender."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from wbc.motions import Motion
from wbc.teleop.acknowledgement import Acknowledgement


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Walk at a velocity; zero stands.

    Attributes:
        forward: m/s, in the robot's heading frame.
        left: m/s, in the robot's heading frame.
        turn: yaw rate to the left, rad/s.
        timeout: time after which the robot stops unless another velocity command comes, s of the
            wall clock since the command was sent.
    """

    forward: float = 0.0
    left: float = 0.0
    turn: float = 0.0
    timeout: float = math.inf

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Forward, left (m/s) and turn (rad/s)."""
        return (self.forward, self.left, self.turn)


@dataclass(frozen=True, slots=True)
class KeepVelocityCommand:
    """Say that the sender of a velocity command is still there: its timeout begins anew.

    It changes nothing else, and nothing at all if another command has taken its place. It is not
    acknowledged.

    Attributes:
        number: number of the velocity command, see `SentCommand`.
        timeout: see `VelocityCommand`.
    """

    number: int
    timeout: float


@dataclass(frozen=True, slots=True)
class PushCommand:
    """Push a simulated robot with a constant force.

    Attributes:
        impulse: (x, y, z) force times duration, N·s.
        duration: s.
        frame: axes of the impulse: "world", or "heading" for forward, left, up of the robot.
        link: frame of the model at whose origin the force acts; empty for the trunk's centre of
            mass.
    """

    impulse: tuple[float, float, float]
    duration: float = 0.1
    frame: Literal["world", "heading"] = "heading"
    link: str = ""


@dataclass(frozen=True, slots=True)
class PullCommand:
    """Pull a link of a simulated robot towards a point by a spring, until the timeout or a release.

    Only the first of consecutive pulls of one link is acknowledged.

    Attributes:
        link: frame of the model that is pulled; empty releases.
        point: where the spring is attached, in axes of the link, m.
        target: where it pulls to, world axes, m.
        timeout: time after which the link is released, s of the wall clock since the command was
            sent.
    """

    link: str = ""
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    timeout: float = 0.5


@dataclass(frozen=True, slots=True)
class MotionCommand:
    """Play a motion, in place of the one that is playing or waiting.

    Attributes:
        motion: a motion that the command handler knows.
    """

    motion: Motion


@dataclass(frozen=True, slots=True)
class StandCommand:
    """Stop walking, end the motion, and stand."""


@dataclass(frozen=True, slots=True)
class GaitParameterCommand:
    """Set a gait parameter.

    Attributes:
        name: field of `wbc.GaitParameters`.
        value: value in the unit of that field.
    """

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class GainCommand:
    """Set a gain of one of the walker's tasks.

    Attributes:
        task: name of the task.
        gain: "weight", "kp" (1/s²) or "kd" (1/s).
        value: new value of the largest row; the other rows keep their ratios to it.
    """

    task: str
    gain: Literal["weight", "kp", "kd"]
    value: float


@dataclass(frozen=True, slots=True)
class FrameTaskCommand:
    """Add a task that holds a link where it is relative to the robot, weight it, or remove it.

    A reset removes it.

    Attributes:
        frame: name of a link above the legs.
        kind: "position" of its origin, or "orientation".
        weight: weight of the task; 0 removes it.
    """

    frame: str
    kind: Literal["position", "orientation"]
    weight: float


@dataclass(frozen=True, slots=True)
class JointCommand:
    """Move joints of arms, trunk and head to positions; the gait alone moves the legs.

    Attributes:
        joints: names of the joints.
        positions: position of each of them, rad.
        duration: time to get there, s of the wall clock since the command was sent; 0 is as fast as
            `max_speed` allows.
        max_speed: largest joint speed, rad/s; half of a joint's own limit if that is less.
    """

    joints: tuple[str, ...]
    positions: tuple[float, ...]
    duration: float = 0.0
    max_speed: float = 1.0


@dataclass(frozen=True, slots=True)
class HandTargetCommand:
    """Lead a hand to a position, standing or walking, or let go of it.

    The position is kept relative to the robot: a hand that is led walks along. It is brought within
    reach of the arm. Playing a motion, standing by a `StandCommand` and a reset let go.

    Attributes:
        side: "left" or "right".
        position: of the hand's frame, world axes, m; None lets go.
    """

    side: str
    position: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class TimeScaleCommand:
    """Run slower than real time.

    Attributes:
        scale: seconds of the plant per second of the wall clock.
    """

    scale: float


@dataclass(frozen=True, slots=True)
class PauseCommand:
    """Pause the loop, or resume it.

    Attributes:
        paused: False resumes.
    """

    paused: bool = True


@dataclass(frozen=True, slots=True)
class ResetCommand:
    """Set the robot back to where the run began, on its feet."""


@dataclass(frozen=True, slots=True)
class StartSessionCommand:
    """End this session, and start another one in its place.

    Attributes:
        robot: name of a robot, or path of a URDF or robot data file.
        terrain: name of the terrain.
        seed: random seed of sensor noise and terrain.
    """

    robot: str
    terrain: str
    seed: int


TeleopCommand: TypeAlias = (
    VelocityCommand
    | KeepVelocityCommand
    | PushCommand
    | PullCommand
    | MotionCommand
    | StandCommand
    | GaitParameterCommand
    | GainCommand
    | FrameTaskCommand
    | JointCommand
    | HandTargetCommand
    | TimeScaleCommand
    | PauseCommand
    | ResetCommand
    | StartSessionCommand
)

#: Commands that change how the robot is controlled, not what it does: they outlast a reset.
PARAMETER_COMMANDS = (GaitParameterCommand, GainCommand, TimeScaleCommand)


def command_label(command: TeleopCommand) -> str:
    """Return what a command is in words, e.g. "velocity command"."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", type(command).__name__).lower()


def command_name(command: TeleopCommand) -> str:
    """Return the name of a command, e.g. "velocity" or "gait_parameter"."""
    name = type(command).__name__.removesuffix("Command")
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def command_json(command: TeleopCommand) -> str:
    """Return the values of a command as JSON; infinite and unknown numbers are null."""
    values: dict[str, Any] = {
        field.name: getattr(command, field.name) for field in dataclasses.fields(command)
    }
    if isinstance(command, MotionCommand):
        motion = command.motion
        values = {
            "name": motion.name,
            **{p.name: getattr(motion, p.name, None) for p in type(motion).parameters()},
        }
    plain = json.loads(json.dumps(values, default=_plain), parse_constant=lambda _: None)
    return json.dumps(plain, ensure_ascii=False)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


@dataclass(frozen=True, slots=True)
class SentCommand:
    """A command with its sender.

    Attributes:
        command: the command.
        source: sender, e.g. "page", "keyboard", "ros" or "script".
        id: number of the command, unique per sender.
        stamp: time of sending, s by `time.monotonic`, which all processes of a machine share.
        reply: tells the sender what became of it.
    """

    command: TeleopCommand
    source: str
    id: int
    stamp: float
    reply: Callable[[Acknowledgement], None] = lambda _: None

    def __str__(self) -> str:
        return f"{command_label(self.command)} from {self.source}"
