"""Offsets that a motion adds to the walker's references: CoM, trunk orientation, weight shift."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from wbc.gait import DcmReference, GaitState
from wbc.geometry.planar import planar_rotation

_H = 1e-3  # s, step of the finite differences of a rotation


def _zeros() -> np.ndarray:
    return np.zeros(3)


@dataclass(slots=True)
class RotationOffset:
    """A rotation that a reference adds to standing upright.

    Attributes:
        is_zero: there is nothing to add; the other attributes are not read.
        vector: (3,) rotation vector φ in heading axes, rad.
        rate: (3,) φ̇, rad/s.
        acceleration: (3,) φ̈, rad/s².
    """

    is_zero: bool = True
    vector: np.ndarray = field(default_factory=_zeros)
    rate: np.ndarray = field(default_factory=_zeros)
    acceleration: np.ndarray = field(default_factory=_zeros)

    def motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the (3, 3) rotation, (3,) angular velocity and acceleration in heading axes."""
        bend = 0.5 * _H * _H * self.acceleration
        before, now, after = (
            np.asarray(pin.exp3(self.vector + h * self.rate + bend * (h != 0.0)))
            for h in (-_H, 0.0, _H)
        )
        first = np.asarray(pin.log3(now @ before.T)) / _H
        second = np.asarray(pin.log3(after @ now.T)) / _H
        return now, 0.5 * (first + second), (second - first) / _H


@dataclass(slots=True)
class ReferenceOffset:
    """The offsets of the walker's references; zero, with centred weight, when walking.

    The walker adds it to what its planner wants, so that balance, contacts and steps stay the
    same whatever a motion does. The CoM's offset c moves the reference of the DCM by c + ċ/ω
    and that of the ZMP by c − c̈/ω²: the linear inverted pendulum superposes. Whoever sets an
    offset keeps it continuous.

    Attributes:
        com: (3,) offset of the CoM, heading axes, m.
        com_velocity: (3,) m/s.
        com_acceleration: (3,) m/s².
        torso: rotation of the upper trunk.
        base: rotation of the root link.
        weight_shift: lateral position of the weight while standing: 0 right sole, 1 left sole.
        weight_shift_velocity: 1/s.
        weight_shift_acceleration: 1/s².
    """

    com: np.ndarray = field(default_factory=_zeros)
    com_velocity: np.ndarray = field(default_factory=_zeros)
    com_acceleration: np.ndarray = field(default_factory=_zeros)
    torso: RotationOffset = field(default_factory=RotationOffset)
    base: RotationOffset = field(default_factory=RotationOffset)
    weight_shift: float = 0.5
    weight_shift_velocity: float = 0.0
    weight_shift_acceleration: float = 0.0

    def planar(self, heading: float) -> tuple[complex, complex, complex]:
        """Return the CoM's offset over the ground, its velocity and its acceleration.

        Args:
            heading: heading of the robot, rad.

        Returns:
            World axes, m, m/s and m/s².
        """
        to_world = planar_rotation(heading)
        c, v, a = (
            complex(*x[:2].tolist()) * to_world
            for x in (self.com, self.com_velocity, self.com_acceleration)
        )
        return c, v, a

    def apply(self, reference: DcmReference, state: GaitState, heading: float) -> DcmReference:
        """The planner's reference, moved by the offset of the CoM and the motion of the weight.

        Args:
            reference: reference of the planner, which has the position of the weight shift already.
            state: phase and feet.
            heading: heading of the robot, rad.
        """
        omega = state.gait.omega
        c, v, a = self.planar(heading)
        if state.at_rest:
            across = state.feet.left.point - state.feet.right.point
            v += self.weight_shift_velocity * across
            a += self.weight_shift_acceleration * across
        return DcmReference(
            reference.dcm + c + v / omega,
            reference.dcm_velocity + v + a / omega,
            reference.zmp + c - a / (omega * omega),
            reference.cmp_offset,
        )
