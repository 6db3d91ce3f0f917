"""What a motion adds to the walker's own references: CoM, trunk attitude, share of the weight."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from wbc.gait import DcmReference, Feet
from wbc.geometry.planar import planar_rotation

_H = 1e-3  # s, of the differences in time of an attitude


def _zeros() -> np.ndarray:
    return np.zeros(3)


@dataclass(slots=True)
class RotationOffset:
    """A rotation that a reference adds to standing is_zero.

    Attributes:
        is_zero: there is nothing to add; the others are not looked at.
        vector: (3,) rotation vector φ in heading axes, rad.
        rate: (3,) φ̇, rad/s.
        acceleration: (3,) φ̈, rad/s².
    """

    is_zero: bool = True
    vector: np.ndarray = field(default_factory=_zeros)
    rate: np.ndarray = field(default_factory=_zeros)
    acceleration: np.ndarray = field(default_factory=_zeros)

    def motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(3, 3) rotation, (3,) angular velocity and acceleration, heading axes."""
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
    """What a motion adds to the walker's references; zero, with centred weight, when walking.

    The walker adds it to what its gait wants, so that balance, contacts and steps stay the
    same whatever a motion does. The CoM's offset c moves the DCM's plan by c + ċ/ω and the
    ZMP's by c − c̈/ω²: the pendulum is linear, plans add up. Whoever sets it sees to it that
    none of it jumps.

    Attributes:
        com: (3,) offset of the CoM, heading axes, m.
        com_velocity: (3,) m/s.
        com_acceleration: (3,) m/s².
        torso: of the upper trunk.
        base: of the root link.
        weight_shift: where the weight is while standing: 0 over the right sole, 1 over the left.
        weight_shift_velocity: 1/s.
        weight_shift_acceleration: 1/s².
        com_bias: by how much the estimated CoM is off, x + iy in heading axes, m; balance
            takes it off.
    """

    com: np.ndarray = field(default_factory=_zeros)
    com_velocity: np.ndarray = field(default_factory=_zeros)
    com_acceleration: np.ndarray = field(default_factory=_zeros)
    torso: RotationOffset = field(default_factory=RotationOffset)
    base: RotationOffset = field(default_factory=RotationOffset)
    weight_shift: float = 0.5
    weight_shift_velocity: float = 0.0
    weight_shift_acceleration: float = 0.0
    com_bias: complex = 0j

    def apply(
        self, plan: DcmReference, omega: float, heading: float, feet: Feet, standing: bool
    ) -> DcmReference:
        """The gait's plan, apply by the offset of the CoM.

        Args:
            plan: of the gait.
            omega: natural frequency, 1/s.
            heading: rad.
            feet: soles as measured.
            standing: whether `weight_shift` counts; the plan already has its position, but
                not its motion.
        """
        to_world = planar_rotation(heading)
        c, v, a = (
            complex(float(x[0]), float(x[1])) * to_world
            for x in (self.com, self.com_velocity, self.com_acceleration)
        )
        if standing:
            across = feet.left.point - feet.right.point
            v += self.weight_shift_velocity * across
            a += self.weight_shift_acceleration * across
        return DcmReference(
            plan.dcm + c + v / omega,
            plan.dcm_velocity + v + a / omega,
            plan.zmp + c - a / (omega * omega),
        )
