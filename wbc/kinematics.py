"""Everything that follows from one state, computed once and shared by all tasks.

Two Pinocchio passes give the dynamics: the composite rigid body algorithm in
its world convention and the non-linear effects. Centre of mass, centroidal
momentum and frame accelerations are then read off their by-products instead of
being computed by passes of their own (see each property).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.robot import Robot
from wbc.state import State


def skew(p: np.ndarray) -> np.ndarray:
    """(3, 3) matrix of the cross product, `skew(p) @ x = p × x`."""
    x, y, z = p
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) cross product; several times faster than `np.cross` on one pair."""
    a0, a1, a2 = a
    b0, b1, b2 = b
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


class FrameKinematics:
    """One frame's placement, velocity, bias acceleration and Jacobian.

    Velocities and Jacobians are those of the frame's origin in world axes
    (Pinocchio's LOCAL_WORLD_ALIGNED): linear velocity first, then angular.

    Attributes:
        placement: `T_world_frame`.
        rotation: (3, 3) axes of the frame in the world.
        position: (3,) origin of the frame in the world, m.
        velocity: (6,) m/s, rad/s.
        bias: (6,) acceleration at zero generalised acceleration, `J̇ v`
            (classical, of the origin), m/s², rad/s².
        jacobian: (6, nv) `velocity = jacobian @ v`.
    """

    __slots__ = ("bias", "jacobian", "placement", "position", "rotation", "velocity")

    def __init__(self, model: pin.Model, data: pin.Data, frame: pin.Frame, frame_id: int) -> None:
        joint = frame.parentJoint
        T_world_joint = data.oMi[joint]
        self.placement = T_world_joint * frame.placement
        self.rotation = self.placement.rotation
        self.position = self.placement.translation
        self.jacobian = pin.getFrameJacobian(model, data, frame_id, pin.LOCAL_WORLD_ALIGNED)
        self.velocity = np.empty(6)
        self.bias = np.empty(6)
        # In joint axes: move the joint's spatial velocity and acceleration (which
        # the non-linear effects left in data.v and data.a_gf, gravity included) to
        # the frame's origin, and add ω × v for the classical acceleration.
        R = T_world_joint.rotation
        p = frame.placement.translation
        twist, accel = data.v[joint], data.a_gf[joint]
        omega, alpha = twist.angular, accel.angular
        linear = twist.linear + cross(omega, p)
        self.velocity[:3] = R @ linear
        self.velocity[3:] = R @ omega
        self.bias[:3] = R @ (accel.linear + cross(alpha, p) + cross(omega, linear))
        self.bias[:3] += model.gravity.linear
        self.bias[3:] = R @ alpha


class Kinematics:
    """Kinematics and dynamics of a robot in one state.

    Args:
        robot: the robot.
        state: where it is; `update` moves on to another state without
            allocating a new Pinocchio workspace.

    Attributes:
        state: the state that all of this belongs to.
        mass_matrix: (nv, nv) M(q), armature included.
        bias_forces: (nv,) h(q, v), Coriolis, centrifugal and gravity.
        p_com: (3,) centre of mass in the world, m.
        J_com: (3, nv) `v_com = J_com v`.
        v_com: (3,) m/s.
        bias_com: (3,) `J̇_com v`, m/s².
        J_angular: (3, nv) angular part of the centroidal momentum matrix,
            `L = J_angular v` about the centre of mass, world axes.
        bias_angular: (3,) `J̇_angular v`, N·m.

    The base rows of M give the momentum about the base's origin (Featherstone,
    Rigid Body Dynamics Algorithms, 2008, §6.2 and §9): with R the base's
    orientation, m the mass and c the centre of mass in base coordinates,
    `J_com = R M[0:3] / m` and `J_angular = R (M[3:6] − c × M[0:3])`.

    Raises:
        StateError: the state has a wrong size, a NaN or a non-unit quaternion.
    """

    def __init__(self, robot: Robot, state: State) -> None:
        self.robot = robot
        self.model = robot.model
        self.data = robot.model.createData()
        self._frame_objects = list(robot.model.frames)
        self._frames: dict[int, FrameKinematics] = {}
        self._mass = pin.computeTotalMass(robot.model)
        self.update(state)

    def update(self, state: State) -> None:
        """Move on to `state`; everything read before belongs to the old one.

        Raises:
            StateError: see `State.checked`.
        """
        state = state.checked(self.model)
        self.state = state
        model, data = self.model, self.data
        pin.crba(model, data, state.q, pin.Convention.WORLD)
        pin.nonLinearEffects(model, data, state.q, state.v)
        self._frames.clear()
        M = self.mass_matrix = data.M
        h = self.bias_forces = data.nle
        R = self.base_rotation = data.oMi[1].rotation
        self.base_position = data.oMi[1].translation
        self.p_com = data.oYcrb[1].lever.copy()
        lever = R.T @ (self.p_com - self.base_position)
        self.J_com = (R @ M[:3]) / self._mass
        self.J_angular = R @ (M[3:6] - skew(lever) @ M[:3])
        self.v_com = self.J_com @ state.v
        self.bias_com = (R @ h[:3]) / self._mass + model.gravity.linear
        self.bias_angular = R @ (h[3:6] - cross(lever, h[:3]))

    def frame(self, frame: str | int) -> pin.SE3:
        """`T_world_frame` of a frame, by name or by frame index.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        return self.motion(frame).placement

    def motion(self, frame: str | int) -> FrameKinematics:
        """Placement, velocity, bias and Jacobian of a frame, by name or by frame index.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        frame_id = self.robot.frame_id(frame) if isinstance(frame, str) else frame
        found = self._frames.get(frame_id)
        if found is None:
            found = FrameKinematics(
                self.model, self.data, self._frame_objects[frame_id], frame_id
            )
            self._frames[frame_id] = found
        return found

    def jacobian(self, frame: str | int) -> np.ndarray:
        """(6, nv) Jacobian of a frame's origin in world axes, linear rows first.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        return self.motion(frame).jacobian

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(self._mass)

    @property
    def angular_momentum(self) -> np.ndarray:
        """(3,) about the centre of mass, world axes, kg·m²/s."""
        return self.J_angular @ self.state.v

    @property
    def centroidal_momentum(self) -> np.ndarray:
        """(6,) linear then angular momentum about the centre of mass, world axes."""
        return np.concatenate((self._mass * self.v_com, self.angular_momentum))
