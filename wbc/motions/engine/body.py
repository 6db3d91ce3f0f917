"""References of CoM, trunk and joints, which the walker tracks on top of its gait."""

from __future__ import annotations

import numpy as np

from wbc.geometry.planar import ground_point, planar_rotation
from wbc.limits.per_joint import default_braking
from wbc.motions.engine.com_reference import ComReference
from wbc.motions.engine.reference import SmoothReference
from wbc.motions.engine.stance import Stance
from wbc.state import State
from wbc.walking import ReferenceOffset, Walker

_MAX_POSTURE_ERROR = 0.3  # rad, of arms and trunk
_HANDOVER_TIME = 1.5  # s, for the posture after an override


class BodyReferences:
    """Smooth references of CoM, trunk and joints; all are at home when the robot stands.

    Args:
        walker: the walker, which tracks them.
        stance: its support polygon and weight shift.

    Attributes:
        com: (3,) offset of the CoM from its place when standing, m; see `ComReference`.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link.
        posture: (na,) joint positions, rad.
        references: all of them by name.
        state: estimated state of this tick; None before the first.
    """

    def __init__(self, walker: Walker, stance: Stance) -> None:
        self._walker, self._stance = walker, stance
        robot, omega = walker.robot, walker.gait.omega
        self.com = ComReference(
            speed=0.3 * omega * robot.leg_length,
            acceleration=0.1 * omega**2,
            omega=omega,
            descent=self._descent,
            support=stance.polygon,
        )
        self.torso = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.pelvis = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.posture = SmoothReference(
            robot.q_nominal[7:],
            speed=0.6 * np.minimum(robot.v_max, 5.0),
            acceleration=0.5 * default_braking(robot),
        )
        self.references: dict[str, SmoothReference] = {
            "com": self.com,
            "torso": self.torso,
            "pelvis": self.pelvis,
            "posture": self.posture,
        }
        self.state: State | None = None
        self._not_legs = np.ones(robot.na, dtype=bool)
        self._not_legs[[index - 6 for leg in robot.legs for index in leg]] = False
        self._offset = ReferenceOffset()

    @property
    def at_home(self) -> bool:
        """Whether all references rest at home."""
        return all(reference.at_home for reference in self.references.values())

    def reset(self) -> None:
        """Put every reference at home. The walker has just been reset."""
        self.posture.home = self._walker.posture.target.copy()
        for reference in self.references.values():
            reference.reset()
        self._walker.reference_offset = self._offset = ReferenceOffset()
        self._bring_com_home()

    def resume(self) -> None:
        """Start from the position and velocity that the robot has, and go home."""
        assert self.state is not None
        for reference in self.references.values():
            reference.reset()
        self._bring_com_home()
        self.posture.start_from(self.state.q[7:], self.state.v[6:])
        self.posture.move_to(self.posture.home, _HANDOVER_TIME)

    def release_com(self) -> None:
        """Drop the CoM's horizontal offset at once; its height goes home from where it is."""
        value, velocity = self.com.value.copy(), self.com.velocity.copy()
        if not (value.any() or velocity.any()):
            return
        value[:2] = velocity[:2] = 0.0
        self.com.start_from(value, velocity)
        self.com.move_to(0.0, 1.0)

    def move_home(self, duration: float) -> None:
        """Send all references home, within a time (s) at least."""
        for reference in self.references.values():
            reference.move_to(reference.home, duration)

    def advance(self, dt: float) -> None:
        """Advance all references by a tick, s."""
        for reference in self.references.values():
            reference.advance(dt)

    def apply(self) -> None:
        """Hand the references and the weight shift to the walker."""
        offset, weight_shift = self._offset, self._stance.weight_shift
        offset.com, offset.com_velocity = self.com.value, self.com.velocity
        offset.com_acceleration = self.com.acceleration
        offset.weight_shift = float(weight_shift.value[0])
        offset.weight_shift_velocity = float(weight_shift.velocity[0])
        offset.weight_shift_acceleration = float(weight_shift.acceleration[0])
        for rotation, reference in ((offset.torso, self.torso), (offset.base, self.pelvis)):
            rotation.is_zero = reference.at_home
            rotation.vector, rotation.rate = reference.value, reference.velocity
            rotation.acceleration = reference.acceleration
        posture = self._walker.posture
        posture.target = self._bounded(self.posture.value)
        posture.velocity = self.posture.velocity
        posture.acceleration = self.posture.acceleration

    def _bounded(self, posture: np.ndarray) -> np.ndarray:
        """Bound the posture error of arms and trunk, for which the CoM would pay.

        A joint whose torque does not suffice stays behind; what it asks for must stay bounded.
        """
        if self.state is None:
            return posture
        error = posture - self.state.q[7:]
        far = self._not_legs & (np.abs(error) > _MAX_POSTURE_ERROR)
        if not far.any():
            return posture
        bounded = np.clip(error, -_MAX_POSTURE_ERROR, _MAX_POSTURE_ERROR)
        return np.where(far, self.state.q[7:] + bounded, posture)

    def _descent(self) -> float:
        q = self._walker.robot.q_nominal if self.state is None else self.state.q
        return self._stance.descent(q)

    def _bring_com_home(self) -> None:
        """Bring the CoM home from its present position and velocity."""
        kin, feet = self._walker.kinematics, self._walker.feet
        to_heading = planar_rotation(-self._walker.heading)
        offset = (ground_point(kin.p_com) - feet.middle) * to_heading
        velocity = ground_point(kin.v_com) * to_heading
        self.com.start_from(
            np.array([offset.real, offset.imag, 0.0]),
            np.array([velocity.real, velocity.imag, float(kin.v_com[2])]),
        )
        self.com.move_to(0.0, 1.0)
