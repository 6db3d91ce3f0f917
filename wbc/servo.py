"""Joint servos: their gains, and the command that one takes."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.errors import JointNotFound, ServoError

if TYPE_CHECKING:
    from wbc.robot import Robot


@dataclass(frozen=True, slots=True, repr=False)
class ServoCommand:
    """The command of one tick to joint servos, each of which exerts

        τ = tau + kp (q − q_measured) + kd (v − v_measured).

    Attributes:
        q: (na,) joint positions, rad (m for prismatic joints), model joint order.
        v: (na,) joint velocities, rad/s.
        tau: (na,) feed-forward torques, N·m.
        kp: (na,) position gains, N·m/rad.
        kd: (na,) velocity gains, N·m·s/rad.
    """

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    kp: np.ndarray
    kd: np.ndarray

    def __repr__(self) -> str:
        held = int(np.count_nonzero(self.kp))
        torque = float(np.abs(self.tau).max(initial=0.0))
        return f"ServoCommand({held} of {self.q.size} joints held, largest torque {torque:.4g} N·m)"

    def torque(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the torques of the servo law at measured positions and velocities, (na,) N·m."""
        torque: np.ndarray = self.tau + self.kp * (self.q - q) + self.kd * (self.v - v)
        return torque

    def as_positions(self) -> np.ndarray:
        """Return the command to servos that take nothing but a position, (na,) rad.

        A servo that exerts kp (q* − q_measured) − kd v_measured exerts the torque of this command
        if q* = q + (tau + kd v) / kp.

        Raises:
            ServoError: a joint has kp = 0, so that no position gives its torque.
        """
        if not self.kp.all():
            joint = int(np.flatnonzero(self.kp == 0.0)[0])
            raise ServoError(
                f"joint {joint} has kp = 0 N·m/rad: it is commanded by torque, and no position "
                "says that; give it a gain"
            )
        positions: np.ndarray = self.q + (self.tau + self.kd * self.v) / self.kp
        return positions


@dataclass(frozen=True, slots=True, repr=False)
class ServoGains:
    """Gains of the servos of a robot's joints.

    Attributes:
        kp: (na,) position gains, N·m/rad, model joint order.
        kd: (na,) velocity gains, N·m·s/rad.

    Raises:
        ServoError: gains of different sizes, negative or not finite.
    """

    kp: np.ndarray
    kd: np.ndarray

    def __post_init__(self) -> None:
        for name in ("kp", "kd"):
            gains = np.asarray(getattr(self, name), dtype=float)
            object.__setattr__(self, name, gains)
            if gains.ndim != 1 or not (np.isfinite(gains).all() and (gains >= 0.0).all()):
                raise ServoError(f"{name} = {gains} must be finite numbers >= 0, one per joint")
        if self.kp.shape != self.kd.shape:
            raise ServoError(f"there are {self.kp.size} gains kp, but {self.kd.size} gains kd")

    def __repr__(self) -> str:
        return (
            f"ServoGains(kp {self.kp.min():.3g} to {self.kp.max():.3g} N·m/rad, "
            f"kd {self.kd.min():.3g} to {self.kd.max():.3g} N·m·s/rad)"
        )

    @classmethod
    def for_robot(
        cls, robot: Robot, frequency: float = 10.0, damping_ratio: float = 1.0
    ) -> ServoGains:
        """Return gains that give each motor the same natural frequency when it moves alone:

            kp = I ω²,  kd = 2 ζ I ω,  ω = 2π frequency,

        with I the inertia of the motor's rotor at the joint (the model's armature): what a servo
        moves while its motor crosses the backlash. For a joint whose rotor inertia is unknown, I is
        1 / (M⁻¹)_ii in the nominal posture, the inertia that it moves while all other joints and
        the base are free. The choice is that of Q. Liao et al., *BeyondMimic: from motion tracking
        to versatile humanoid control via guided diffusion*, 2025. Such servos are soft: the
        feed-forward torque carries the robot.

        Args:
            robot: the robot.
            frequency: natural frequency, Hz.
            damping_ratio: ζ; 1 is critical.

        Raises:
            ServoError: a frequency or damping ratio that is not positive.
        """
        for name, value in (("frequency", frequency), ("damping_ratio", damping_ratio)):
            if not (math.isfinite(value) and value > 0.0):
                raise ServoError(f"{name} = {value} must be positive and finite")
        model = robot.model
        inverse = pin.computeMinverse(model, model.createData(), robot.q_nominal)
        rotor = np.array(model.armature[6:])
        inertia = np.where(rotor > 0.0, rotor, 1.0 / np.diag(inverse)[6:])
        omega = 2.0 * math.pi * frequency
        return cls(inertia * omega**2, 2.0 * damping_ratio * omega * inertia)

    def with_torque_control(self, robot: Robot, joints: Collection[str]) -> ServoGains:
        """Return the gains of a hybrid robot, some joints of which are commanded by torque alone.

        Args:
            robot: the robot.
            joints: names of the joints that take a torque; their gains are zero.

        Raises:
            JointNotFound: the robot has no such actuated joint.
        """
        names = list(robot.joint_names)
        for joint in joints:
            if joint not in names:
                raise JointNotFound(joint, names, "ServoGains.with_torque_control")
        held = np.array([name not in joints for name in names], dtype=float)
        return ServoGains(self.kp * held, self.kd * held)
