"""Joint servos with delay, friction and backlash, instead of ideal torque sources."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.command import Command
from wbc.errors import PlantError
from wbc.robot import Robot
from wbc.servo import ServoCommand, ServoGains
from wbc.servo_reference import ServoReference


@dataclass(frozen=True, slots=True)
class JointServos:
    """Properties of the servos of a position-controlled robot.

    At each physics step every servo exerts `τ = tau + kp (q − θ) + kd (v − θ̇)` of the newest
    `ServoCommand` that has reached it, clipped to the joint's torque limit, with θ the angle of
    its motor, which the encoder measures.

    Attributes:
        gains: gains of the servos; a joint whose gains are zero is a torque source. With None they
            are `ServoGains.for_robot`.
        friction: Coulomb friction of a joint, as a share of its torque limit.
        compensation: share of the friction that the references compensate, as if it had been
            identified; see `ServoReference`.
        damping: viscous friction, as a share of the torque limit per rad/s.
        backlash: play between motor and joint, rad. A motor that reverses its torque crosses the
            play with its rotor inertia (the model's armature), and exerts nothing on the joint
            meanwhile.

    Raises:
        PlantError: a property that is negative or not finite.
    """

    gains: ServoGains | None = None
    friction: float = 0.03
    compensation: float = 0.7
    damping: float = 0.0
    backlash: float = math.radians(0.5)

    def __post_init__(self) -> None:
        for name in ("friction", "compensation", "damping", "backlash"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise PlantError(f"JointServos: {name} = {value} must be finite and >= 0")


class Servos:
    """The servos of one plant, in the place of `Motors`.

    Args:
        robot: its torque limits and rotor inertias.
        servos: properties.
        dt: control period, s.
        timestep: time step of the physics, s.
        latency: age of a command when it reaches the servos, physics steps.

    Raises:
        PlantError: the gains are not those of the robot's joints, or there is backlash at a joint
            without rotor inertia.
    """

    def __init__(
        self, robot: Robot, servos: JointServos, dt: float, timestep: float, latency: int
    ) -> None:
        gains = servos.gains or ServoGains.for_robot(robot)
        if gains.kp.shape != (robot.na,):
            raise PlantError(
                f"the servo gains are for {gains.kp.size} joints, {robot.name} has {robot.na}"
            )
        self._rotor = np.array(robot.model.armature[6:])
        if servos.backlash > 0.0 and not (self._rotor > 0.0).all():
            joint = robot.joint_names[int(np.flatnonzero(self._rotor <= 0.0)[0])]
            raise PlantError(
                f"joint '{joint}' has no rotor inertia to cross a backlash with: state its "
                "armature, or set backlash=0"
            )
        self._tau_max = np.array(robot.tau_max, dtype=float)
        known = servos.compensation * servos.friction * self._tau_max
        self._reference = ServoReference(gains, dt, friction=known)
        self._timestep = timestep
        self._latency = latency
        self._half_play = 0.5 * servos.backlash
        self._queue: deque[tuple[int, ServoCommand]] = deque()
        self._command: ServoCommand | None = None
        self._play, self._play_velocity = np.zeros((2, robot.na))

    def clear(self) -> None:
        """Forget all commands, and put the motors in the middle of their play."""
        self._queue.clear()
        self._command = None
        self._reference.reset()
        self._play[:] = self._play_velocity[:] = 0.0

    def command(self, command: Command | ServoCommand, step: int) -> None:
        """Send a command at a physics step (since the reset); the first one acts at once.

        Raises:
            PlantError: the command is not finite.
        """
        servo = command if isinstance(command, ServoCommand) else self._reference.update(command)
        if not math.isfinite(
            servo.tau.dot(servo.tau) + servo.q.dot(servo.q) + servo.v.dot(servo.v)
        ):
            raise PlantError(
                "the command to the servos is not finite; look at the controller behind it"
            )
        self._queue.append((step + self._latency if step else 0, servo))

    def torque(self, step: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Advance the motors by a physics step; return the torques on the joints, (na,) N·m.

        Args:
            step: physics steps since the reset.
            q: joint positions, rad.
            v: joint velocities, rad/s.
        """
        while self._queue and self._queue[0][0] <= step:
            self._command = self._queue.popleft()[1]
        assert self._command is not None
        play, velocity, half = self._play, self._play_velocity, self._half_play
        command, limit = self._command, self._tau_max
        if half == 0.0:
            torque: np.ndarray = np.clip(command.torque(q, v), -limit, limit)
            return torque
        # The damping is implicit in the motor's velocity: a drive's own loop is many times faster
        # than the physics step.
        share = self._timestep / self._rotor
        tau = command.torque(q + play, v)
        tau -= command.kd * (velocity + share * tau) / (1.0 + share * command.kd)
        tau = np.minimum(np.maximum(tau, -limit), limit)
        velocity += share * tau
        play += self._timestep * velocity
        at_high, at_low = play >= half, play <= -half
        np.clip(play, -half, half, out=play)
        velocity[at_high | at_low] = 0.0
        # Only a motor that presses against the side of its play moves the joint.
        pressing: np.ndarray = (at_high & (tau > 0.0)) | (at_low & (tau < 0.0))
        return np.where(pressing, tau, 0.0)

    def add_play(self, reading: np.ndarray) -> None:
        """Turn exact joint readings `[q, v, …]` into those of encoders at the motors."""
        na = self._play.size
        reading[:na] += self._play
        reading[na : 2 * na] += self._play_velocity


def set_friction(model: Any, robot: Robot, servos: JointServos, dofs: np.ndarray) -> None:
    """Write the joints' friction into a MuJoCo model.

    Args:
        model: the model.
        robot: its torque limits scale the friction.
        servos: properties.
        dofs: MuJoCo's index of each joint's velocity.
    """
    model.dof_frictionloss[dofs] = servos.friction * robot.tau_max
    model.dof_damping[dofs] = servos.damping * robot.tau_max
