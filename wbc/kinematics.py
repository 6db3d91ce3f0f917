"""Everything that follows from one state, computed once and shared by all tasks.

Two Pinocchio passes give most of it: the composite rigid body algorithm in its world
convention and the non-linear effects; the forward kinematics at zero acceleration is computed
when a frame's motion is first used. The centroidal quantities are read off the base rows of the
mass matrix and of the non-linear effects instead of being computed by passes of their own.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import StateError
from wbc.robot import RobotModel
from wbc.state import State

_WORLD_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
_FRAME_AXES = pin.ReferenceFrame.LOCAL
_SE3_BYTES = 12 * 8  # rotation, translation
_MOTION_BYTES = 6 * 8  # linear, angular


class Centroid:
    """Centre of mass and angular momentum about it, in world axes, as one motion.

    Attributes:
        position: (3,) centre of mass, m.
        velocity: (6,) CoM velocity, m/s; angular momentum, kg·m²/s.
        bias: (6,) rate of `velocity` at zero generalised acceleration, m/s², N·m.
        jacobian: (6, nv) `velocity = jacobian @ v`.
    """

    __slots__ = ("bias", "jacobian", "position", "velocity")

    def __init__(
        self, position: np.ndarray, jacobian: np.ndarray, velocity: np.ndarray, bias: np.ndarray
    ) -> None:
        self.position = position
        self.jacobian = jacobian
        self.velocity = velocity
        self.bias = bias


class FrameKinematics:
    """One frame's placement, velocity, bias acceleration and Jacobian.

    All are those of the frame's origin, linear part first, then angular.

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

    def __init__(
        self, model: pin.Model, data: pin.Data, frame_id: int, axes: pin.ReferenceFrame
    ) -> None:
        self.placement = pin.updateFramePlacement(model, data, frame_id)
        self.rotation: np.ndarray = self.placement.rotation
        self.position: np.ndarray = self.placement.translation
        self.jacobian: np.ndarray = pin.getFrameJacobian(model, data, frame_id, axes)
        velocity = pin.getFrameVelocity(model, data, frame_id, axes)
        bias = pin.getFrameClassicalAcceleration(model, data, frame_id, axes)
        self.velocity: np.ndarray = velocity.vector
        self.bias: np.ndarray = bias.vector


def _are_every(step: int, addresses: list[int]) -> bool:
    """Return whether addresses in memory follow one another at a step, bytes."""
    first = addresses[0]
    return addresses == list(range(first, first + step * len(addresses), step))


class Kinematics:
    """Kinematics and dynamics of a robot in one state.

    Args:
        robot: the robot.
        state: where it is; `update` moves on to another state without
            allocating a new Pinocchio workspace.

    Attributes:
        state: the state that all of this belongs to.
        mass: total mass, kg.
        mass_matrix: (nv, nv) M(q), armature included.
        bias_forces: (nv,) h(q, v), Coriolis, centrifugal and gravity.
        previous_acceleration: (nv,) what was computed from the state before, for limits on jerk;
            at first zero.

    Raises:
        StateError: the state has a wrong size, a NaN or a non-unit quaternion.
    """

    def __init__(self, robot: RobotModel, state: State) -> None:
        self.robot = robot
        self.model = robot.model
        self.data = robot.model.createData()
        self.mass = float(pin.computeTotalMass(robot.model))
        self._nq, self._nv = robot.nq, robot.nv
        self._zero_acceleration = self.previous_acceleration = np.zeros(robot.nv)
        # Views of Pinocchio's memory, which the passes of `update` fill.
        self._com: np.ndarray = self.data.oYcrb[1].lever
        self._base_rotation: np.ndarray = self.data.oMi[1].rotation
        self._gravity = np.concatenate((robot.model.gravity.linear, np.zeros(3)))
        self._world: dict[int, FrameKinematics] = {}
        self._local: dict[int, FrameKinematics] = {}
        self._joint_frames: dict[int, int] = {}
        self._centroid: Centroid | None = None
        self._p_com: np.ndarray | None = None
        self._velocities_propagated = False
        self._copied: list[str] = []  # attributes that are no views
        self.update(state)

    def __getstate__(self) -> Any:
        """Return what Pinocchio's workspace is computed from again."""
        return self.robot, self.state, self.previous_acceleration

    def __setstate__(self, state: Any) -> None:
        *arguments, previous_acceleration = state
        self.__init__(*arguments)  # type: ignore[misc]
        self.previous_acceleration = previous_acceleration

    def update(self, state: State) -> None:
        """Continue with another state; arrays that were read before still describe the old one.

        Raises:
            StateError: see `State.validated`.
        """
        if not isinstance(state, State):
            raise StateError(
                f"{type(state).__name__} is no state: give wbc.State(q, v) with q of "
                f"({self._nq},) and v of ({self._nv},)"
            )
        valid = state.is_valid(self._nq, self._nv)
        self.state = state = state if valid else state.validated(self.model)
        self._propagate(state.q, state.v)
        self._world.clear()
        self._local.clear()
        self._centroid = self._p_com = None
        self._velocities_propagated = False
        while self._copied:
            delattr(self, self._copied.pop())

    def _propagate(self, q: np.ndarray, v: np.ndarray) -> None:
        """Run Pinocchio's passes for a state."""
        model, data = self.model, self.data
        self.mass_matrix: np.ndarray = pin.crba(model, data, q, pin.Convention.WORLD)
        self.bias_forces: np.ndarray = pin.nonLinearEffects(model, data, q, v)

    @cached_property
    def joint_placements(self) -> np.ndarray:
        """(njoints, 12) placements in `data.oMi`: the rotation's columns, then the translation.

        The rows are Pinocchio's own memory, valid as long as `data` and changed by every pass
        over the model: compiled code reads all placements without a call for each. A build of
        Pinocchio that does not store them one after the other gets a copy per update instead.
        """
        placements = [self.data.oMi[i] for i in range(self.model.njoints)]
        first = placements[0].rotation.T
        addresses = [placement.rotation.ctypes.data for placement in placements]
        in_a_row = placements[0].translation.ctypes.data == addresses[0] + first.nbytes
        if not in_a_row or not _are_every(_SE3_BYTES, addresses):
            self._copied.append("joint_placements")
            return np.array([[*T.rotation.T.flat, *T.translation] for T in placements])
        return np.lib.stride_tricks.as_strided(first, (len(addresses), 12), (_SE3_BYTES, 8))

    @cached_property
    def joint_velocities(self) -> np.ndarray:
        """(njoints, 6) velocities of the joints' frames in their own axes, m/s, then rad/s.

        Pinocchio's own memory as `joint_placements`, or a copy per update.
        """
        velocities = [self.data.v[i].vector for i in range(self.model.njoints)]
        addresses = [velocity.ctypes.data for velocity in velocities]
        if not _are_every(_MOTION_BYTES, addresses):
            self._copied.append("joint_velocities")
            return np.array(velocities)
        return np.lib.stride_tricks.as_strided(
            velocities[0], (len(addresses), 6), (_MOTION_BYTES, 8)
        )

    @property
    def previous_velocity(self) -> np.ndarray:
        """(nv,) velocity before the step; with dynamics that of the state."""
        return self.state.v

    def frame(self, frame: str | int) -> pin.SE3:
        """Return `T_world_frame` of a frame, by name or by frame index.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        frame_id = self.robot.frame_id(frame) if isinstance(frame, str) else frame
        return pin.updateFramePlacement(self.model, self.data, frame_id)

    @property
    def base(self) -> pin.SE3:
        """`T_world_base`."""
        return self.data.oMi[1].copy()

    @property
    def p_com(self) -> np.ndarray:
        """Centre of mass (3,) in the world, m."""
        if self._p_com is None:
            self._p_com = self._com.copy()
        return self._p_com

    def motion(self, frame: str | int) -> FrameKinematics:
        """Return a frame's kinematics in world axes, by name or by frame index.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        return self._motion(frame, self._world, _WORLD_AXES)

    def motion_local(self, frame: str | int) -> FrameKinematics:
        """Return a frame's kinematics in its own axes, by name or by frame index.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        return self._motion(frame, self._local, _FRAME_AXES)

    def _motion(
        self, frame: str | int, cache: dict[int, FrameKinematics], axes: pin.ReferenceFrame
    ) -> FrameKinematics:
        frame_id = self.robot.frame_id(frame) if isinstance(frame, str) else frame
        found = cache.get(frame_id)
        if found is None:
            if not self._velocities_propagated:
                state = self.state
                pin.forwardKinematics(
                    self.model, self.data, state.q, state.v, self._zero_acceleration
                )
                self._velocities_propagated = True
            found = cache[frame_id] = FrameKinematics(self.model, self.data, frame_id, axes)
        return found

    def joint_frame(self, joint_id: int) -> int:
        """Return the index of the frame of a joint, which moves with the body behind it."""
        found = self._joint_frames.get(joint_id)
        if found is None:
            name = self.model.names[joint_id]
            found = self._joint_frames[joint_id] = self.model.getFrameId(name, pin.FrameType.JOINT)
        return found

    def jacobian(self, frame: str | int) -> np.ndarray:
        """Return the Jacobian (6, nv) of a frame's origin in world axes, linear rows first.

        Raises:
            FrameNotFound: the model has no frame of that name.
        """
        return self.motion(frame).jacobian

    @property
    def J_com(self) -> np.ndarray:
        """Jacobian (3, nv) of the centre of mass, `v_com = J_com v`."""
        return self.centroid.jacobian[:3]

    @property
    def v_com(self) -> np.ndarray:
        """Velocity (3,) of the centre of mass, m/s."""
        if self._centroid is not None:
            return self._centroid.velocity[:3]
        # The base's momentum in base axes, turned into the world and over the mass.
        momentum = self.mass_matrix[:3].dot(self.state.v)
        return np.asarray(self._base_rotation.dot(momentum) / self.mass)

    @property
    def bias_com(self) -> np.ndarray:
        """Bias acceleration (3,) of the centre of mass, `J̇_com v`, m/s²."""
        return self.centroid.bias[:3]

    @property
    def J_angular(self) -> np.ndarray:
        """Matrix (3, nv) with `angular_momentum = J_angular v`."""
        return self.centroid.jacobian[3:]

    @property
    def angular_momentum(self) -> np.ndarray:
        """Angular momentum (3,) about the centre of mass, world axes, kg·m²/s."""
        return self.centroid.velocity[3:]

    @property
    def bias_angular(self) -> np.ndarray:
        """Rate (3,) of the angular momentum at zero acceleration, `J̇_angular v`, N·m."""
        return self.centroid.bias[3:]

    @property
    def centroidal_momentum(self) -> np.ndarray:
        """Linear (kg·m/s), then angular momentum (kg·m²/s) about the centre of mass, world axes."""
        return np.concatenate((self.mass * self.v_com, self.angular_momentum))

    @property
    def centroid(self) -> Centroid:
        """Motion of the centre of mass, and angular momentum.

        The base rows of M are the momentum about the base's origin in base axes, those
        of h its rate less gravity (Featherstone, Rigid Body Dynamics Algorithms, 2008,
        §9). With R the base's orientation, m the mass and c the centre of mass seen from
        the base's origin, both in world axes, the Jacobian is `X M[0:6]` for

            X = [ R/m       0 ]
                [ −[c]× R   R ].
        """
        if self._centroid is None:
            base = self.base
            to_com = pin.SE3(base.rotation, base.translation - self.p_com)
            X = to_com.toDualActionMatrix()
            X[:3] /= self.mass
            A = X.dot(self.mass_matrix[:6])
            rate = X.dot(self.bias_forces[:6]) + self._gravity
            self._centroid = Centroid(self.p_com, A, A.dot(self.state.v), rate)
        return self._centroid
