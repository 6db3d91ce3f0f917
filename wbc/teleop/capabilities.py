"""Which commands a robot in a loop takes, within which bounds."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import did_you_mean, short_repr
from wbc.gait import VelocityLimits
from wbc.motions import Motion, MotionPlayer
from wbc.motions.engine import check_importable
from wbc.robot import Robot
from wbc.teleop import commands
from wbc.teleop.acknowledgement import CommandRefused
from wbc.teleop.frame_tasks import MAX_WEIGHT
from wbc.teleop.number_checks import check_number, check_place
from wbc.teleop.parameters import (
    GAIT,
    TIME_SCALE,
    VELOCITY,
    TunableParameter,
    tunable_parameters,
)
from wbc.teleop.session_choices import SessionChoices

_MAX_PUSH = 2.0  # m/s: the largest push changes the robot's velocity by that
_PUSH_DURATION = (0.01, 2.0)  # s
_MAX_PULL = 10.0  # s without a new command
_ROUNDING = 1e-6  # what a bound may be exceeded by, as a share or in rad


@dataclass(frozen=True, eq=False)
class Capabilities:
    """The commands that a robot takes, and their bounds; the one place where they are validated.

    Attributes:
        parameters: parameters that can be set.
        motions: motions that can be played.
        max_impulse: largest push, N·s; 0 if the robot cannot be pushed.
        can_reset: whether the robot can be set back to the start.
        joints: name -> (lowest, highest) position, rad, of the joints that commands may move.
        leg_joints: names of the joints that the gait needs.
        links: names of the frames that can be pushed.
        can_pull: whether a link can be pulled by a spring.
        task_frames: names of the links that a task can hold; not those of the legs.
        hands: sides whose hand can be led to a position.
        sessions: what another session may be started with; None if none can be.
    """

    parameters: tuple[TunableParameter, ...]
    motions: tuple[type[Motion], ...]
    max_impulse: float
    can_reset: bool
    joints: Mapping[str, tuple[float, float]]
    leg_joints: frozenset[str]
    links: frozenset[str] = frozenset()
    can_pull: bool = False
    task_frames: tuple[str, ...] = ()
    hands: tuple[str, ...] = ()
    sessions: SessionChoices | None = None

    @staticmethod
    def of(
        player: MotionPlayer,
        plant: Any,
        motions: Sequence[type[Motion]],
        time_scale: bool,
        sessions: SessionChoices | None = None,
    ) -> Capabilities:
        """Return the capabilities of a robot in a loop.

        Args:
            player: controller of the robot.
            plant: may have `push` and `reset`.
            motions: motions that can be played.
            time_scale: whether the loop can run slower than real time.
            sessions: what another session may be started with.

        Raises:
            MotionError: another process could not import a motion.
        """
        for motion in motions:
            check_importable(motion)
        robot = player.robot
        legs = {int(i) - 6 for leg in robot.legs for i in leg}
        names = robot.joint_names
        return Capabilities(
            parameters=tunable_parameters(player.walker, time_scale),
            motions=tuple(motions),
            max_impulse=_MAX_PUSH * robot.mass if hasattr(plant, "push") else 0.0,
            can_reset=hasattr(plant, "reset"),
            joints={
                name: (float(robot.q_min[i]), float(robot.q_max[i]))
                for i, name in enumerate(names)
                if i not in legs
            },
            leg_joints=frozenset(names[i] for i in legs),
            links=frozenset(frame.name for frame in robot.model.frames[1:]),
            can_pull=hasattr(plant, "pull"),
            task_frames=_upper_links(robot, legs),
            hands=player.context.hands.sides,
            sessions=sessions,
        )

    def parameter(self, name: str) -> TunableParameter:
        """Return the parameter of that name.

        Raises:
            CommandRefused: there is none.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        names = [parameter.name for parameter in self.parameters]
        raise CommandRefused(f"no parameter {short_repr(name)}{did_you_mean(str(name), names)}")

    @property
    def max_velocity(self) -> VelocityLimits:
        """The set of velocities that the robot walks at; what is beyond is clamped into it."""
        forward, left, turn = (p for p in self.parameters if p.group == VELOCITY)
        return VelocityLimits(forward.high, -forward.low, left.high, turn.high)

    def check(self, command: commands.TeleopCommand) -> None:
        """Refuse a command that is invalid for this robot.

        Raises:
            CommandRefused: the text names the value and the bounds.
        """
        match command:
            case commands.VelocityCommand(forward, left, turn, timeout):
                for name, value in (("forward", forward), ("left", left), ("turn", turn)):
                    self._check_parameter(f"{VELOCITY}.{name}", value)
                check_number("timeout", timeout, 0.0, math.inf, "s")
            case commands.KeepVelocityCommand(_, timeout):
                check_number("timeout", timeout, 0.0, math.inf, "s")
            case commands.PushCommand():
                self._check_push(command)
            case commands.PullCommand():
                self._check_pull(command)
            case commands.MotionCommand(motion):
                if type(motion) not in self.motions:
                    raise unknown_motion(getattr(motion, "name", motion), self.motions)
            case commands.GaitParameterCommand(name, value):
                self._check_parameter(f"{GAIT}.{name}", value)
            case commands.GainCommand(task, gain, value):
                if task in (VELOCITY, GAIT):
                    raise CommandRefused(f"'{task}' is not a task, and has no gains")
                self._check_parameter(f"{task}.{gain}", value)
            case commands.TimeScaleCommand(scale):
                if TIME_SCALE not in (p.name for p in self.parameters):
                    raise CommandRefused("this loop does not run by the wall clock: no time scale")
                self._check_parameter(TIME_SCALE, scale)
            case commands.JointCommand():
                self._check_joints(command)
            case commands.HandTargetCommand(side, position):
                if side not in self.hands:
                    raise CommandRefused(f"the robot has no hand on the side {short_repr(side)}")
                if position is not None:
                    check_place("position", position)
            case commands.FrameTaskCommand(frame, kind, weight):
                if frame not in self.task_frames:
                    near = did_you_mean(frame, self.task_frames) if isinstance(frame, str) else ""
                    raise CommandRefused(f"no task can hold {short_repr(frame)}{near}")
                if kind not in ("position", "orientation"):
                    raise CommandRefused(
                        f"kind is {short_repr(kind)}; it is 'position' or 'orientation'"
                    )
                check_number("weight", weight, 0.0, MAX_WEIGHT)
            case commands.PauseCommand(paused):
                if not isinstance(paused, bool):
                    raise CommandRefused(f"pause is {short_repr(paused)}; it is true or false")
            case commands.ResetCommand():
                if not self.can_reset:
                    raise CommandRefused("this robot cannot be reset: it is not simulated")
            case commands.StartSessionCommand():
                if self.sessions is None:
                    raise CommandRefused("no other session can be started from here")
                self.sessions.check(command)
            case commands.StandCommand():
                pass
            case _:
                raise CommandRefused(f"{short_repr(command)} is not a command of wbc.teleop")

    def _check_parameter(self, name: str, value: Any) -> None:
        self.parameter(name).check(value)

    def _check_push(self, command: commands.PushCommand) -> None:
        if not self.max_impulse:
            raise CommandRefused("this robot cannot be pushed: it is not simulated")
        limit = self.max_impulse
        if np.shape(command.impulse) != (3,):
            raise CommandRefused(f"push is {short_repr(command.impulse)}; it is (x, y, z) in N·s")
        for part in command.impulse:
            check_number("push", part, -limit, limit, "N·s")
        check_number("duration", command.duration, *_PUSH_DURATION, "s")
        size = math.hypot(*command.impulse)
        if size > (1.0 + _ROUNDING) * limit:
            raise CommandRefused(f"push: {size:.4g} N·s; at most {limit:.4g} N·s")
        if command.frame not in ("world", "heading"):
            raise CommandRefused(
                f"frame is {short_repr(command.frame)}; it is 'world' or 'heading'"
            )
        self._check_link(command.link)

    def _check_pull(self, command: commands.PullCommand) -> None:
        if not self.can_pull:
            raise CommandRefused("this robot cannot be pulled: it is not simulated")
        self._check_link(command.link)
        check_place("point", command.point)
        check_place("target", command.target)
        check_number("timeout", command.timeout, 0.0, _MAX_PULL, "s")

    def _check_link(self, link: Any) -> None:
        if not isinstance(link, str) or (link and link not in self.links):
            near = did_you_mean(link, self.links) if isinstance(link, str) else ""
            raise CommandRefused(f"the robot has no link {short_repr(link)}{near}")

    def _check_joints(self, command: commands.JointCommand) -> None:
        names, positions = command.joints, command.positions
        self.check_joint_names(names)
        if len(positions) != len(names):
            raise CommandRefused(f"{len(names)} joints have {len(positions)} positions")
        for name, position in zip(names, positions, strict=True):
            low, high = self.joints[name]
            check_number(name, position, low - _ROUNDING, high + _ROUNDING, "rad")
        check_number("duration", command.duration, 0.0, math.inf, "s")
        check_number("max_speed", command.max_speed, 1e-3, math.inf, "rad/s")

    def check_joint_names(self, names: Sequence[str]) -> None:
        """Refuse names of joints that commands may not move.

        Raises:
            CommandRefused: a joint is unknown, named twice or part of a leg, or there are none.
        """
        for name in names:
            if name in self.leg_joints:
                raise CommandRefused(f"'{name}' is a joint of a leg, which the gait needs")
            if name not in self.joints:
                near = did_you_mean(name, self.joints)
                raise CommandRefused(f"there is no joint '{name}'{near}")
        if len(set(names)) != len(names):
            raise CommandRefused("a joint is named twice")
        if not names:
            raise CommandRefused("the command names no joints")


def _upper_links(robot: Robot, legs: Collection[int]) -> tuple[str, ...]:
    """Return the names of the links that no joint of a leg moves alone, sorted.

    Args:
        robot: the robot.
        legs: indices of the legs' joints into (na,) vectors.
    """
    leg_joints = {robot.model.getJointId(robot.joint_names[i]) for i in legs}
    return tuple(
        sorted(
            frame.name
            for frame in robot.model.frames
            if frame.type == pin.BODY and frame.parentJoint not in leg_joints | {0}
        )
    )


def unknown_motion(name: Any, motions: Sequence[type[Motion]]) -> CommandRefused:
    """Return the error for a motion that is not offered."""
    names = [motion.name for motion in motions]
    near = did_you_mean(name, names) if isinstance(name, str) else ""
    return CommandRefused(f"no motion {short_repr(name)}{near}")
