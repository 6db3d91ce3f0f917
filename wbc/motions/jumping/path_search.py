"""Finds the path of a jump: inverse kinematics without angular momentum."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.motions.jumping.path import JumpPath, gravity_of
from wbc.robot import Robot

_POINTS = 33
_SUBSTEPS = 2
_FEWEST = 3
_CONVERGED = 1e-10
_REACHED = 1e-6  # m, rad
_ITERATIONS = 60
_STEP = 0.2  # rad, largest joint step of one Gauss-Newton iteration
_MARGIN = 0.05  # rad that the legs keep from their position limits
_MOMENTUM_SCALE = 0.1  # makes momentum rows comparable to lengths


def trace_path(robot: Robot, top: float, depth: float, stillness: float) -> JumpPath | None:
    """The path down from the height at which the trunk is upright; None if that is too high.

    It ends where a leg's joint comes near its position limit, if not before.

    Args:
        robot: the robot.
        top: greatest height of the CoM above the soles, m.
        depth: how far it goes down, m.
        stillness: weight of (dq/dz)² of waist and arms against the squares of their torque
            shares per m/s²: with less they swing more, and take less torque in flight.
    """
    tracer = _Tracer(robot, stillness)
    path = tracer.trace_path(np.linspace(top - depth, top, _POINTS))
    if path is not None and len(path.height) < _POINTS:  # what is left of it deserves as many
        path = tracer.trace_path(np.linspace(float(path.height[0]), top, _POINTS))
    return path


class _Tracer:
    """Follows the path down from its upper end."""

    def __init__(self, robot: Robot, stillness: float) -> None:
        self._robot = robot
        self._model = model = robot.model
        self._data = data = model.createData()
        self._legs = np.array(sorted(i for leg in robot.legs for i in leg))
        self._free = np.concatenate((np.arange(6), self._legs))
        self._others = np.setdiff1d(np.arange(model.nv), self._free)
        self._still = np.zeros(model.nv)
        self._still[self._others] = stillness
        self._ids = [sole.frame_id for sole in robot.soles]
        self._trunk = [robot.frame_id(name) for name in (robot.torso, robot.base)]
        pin.framesForwardKinematics(model, data, robot.q_nominal)
        self._soles = [data.oMf[i].copy() for i in self._ids]
        self._middle = 0.5 * (self._soles[0].translation + self._soles[1].translation)
        self._upright = [data.oMf[i].rotation.copy() for i in self._trunk]
        self._base = data.oMi[1].rotation.copy()

    def trace_path(self, heights: np.ndarray) -> JumpPath | None:
        q = self._settle(self._robot.q_nominal.copy(), heights[-1], upright=True)
        if np.abs(self._rows(q, heights[-1], upright=True)[1]).max() > _REACHED:
            return None
        configurations, tangents = [q], [self._tangent(q)]
        for k in range(len(heights) - 2, -1, -1):
            step = (heights[k] - heights[k + 1]) / _SUBSTEPS
            for _ in range(_SUBSTEPS):
                middle = pin.integrate(self._model, q, 0.5 * step * self._tangent(q))
                q = pin.integrate(self._model, q, step * self._tangent(middle))
            q = self._settle(q, heights[k], upright=False)
            if not self._within_limits(q):
                break
            configurations.append(q)
            tangents.append(self._tangent(q))
        if len(tangents) < _FEWEST:
            return None
        height = heights[-len(tangents) :]
        q_all, tangent = np.array(configurations[::-1]), np.array(tangents[::-1])
        bend = np.asarray(np.gradient(tangent, height, axis=0))
        force = np.array([self._force(*row) for row in zip(q_all, tangent, bend, strict=True)])
        lean = np.array([self._lean(q) for q in q_all])
        return JumpPath(self._robot, height, q_all, tangent, bend, lean, force)

    def _within_limits(self, q: np.ndarray) -> bool:
        legs, robot = self._legs - 6, self._robot
        play = np.minimum(q[7:] - robot.q_min, robot.q_max - q[7:])[legs]
        return bool((play > _MARGIN).all())

    def _lean(self, q: np.ndarray) -> list[float]:
        pin.framesForwardKinematics(self._model, self._data, q)
        return [
            float(pin.log3(self._data.oMf[i].rotation @ R.T)[1])
            for i, R in zip(self._trunk, self._upright, strict=True)
        ]

    def _force(self, q: np.ndarray, tangent: np.ndarray, bend: np.ndarray) -> np.ndarray:
        model, data, still = self._model, self._data, np.zeros(self._model.nv)
        gravity = pin.rnea(model, data, q, still, still).copy()
        inertia = pin.rnea(model, data, q, still, tangent) - gravity
        centrifugal = pin.rnea(model, data, q, tangent, bend) - gravity
        return np.column_stack((inertia, centrifugal, gravity))

    def _settle(self, q: np.ndarray, height: float, upright: bool) -> np.ndarray:
        """Gauss-Newton with base and legs on soles, CoM and the trunk's attitude."""
        for _ in range(_ITERATIONS):
            J, e = self._rows(q, height, upright)
            if np.abs(e).max() < _CONVERGED:
                break
            step = np.zeros(self._model.nv)
            step[self._free] = np.linalg.lstsq(J[:, self._free], e, rcond=1e-10)[0]
            step *= min(1.0, _STEP / float(np.abs(step).max()))
            q = pin.integrate(self._model, q, step)
        return q

    def _tangent(self, q: np.ndarray) -> np.ndarray:
        """(nv,) q': no momentum, and the least torque share of waist and arms in flight.

        There, accelerated by z̈, they take (a − c/g) z̈; see `JumpPath.flight`.
        """
        model, data, others = self._model, self._data, self._others
        J, e = self._rows(q, 0.0, upright=False)
        rise = np.zeros(len(e))
        rise[14] = 1.0
        limit = model.effortLimit[others]
        weight = pin.computeGeneralizedGravity(model, data, q)[others] / limit
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        share = M[others] / limit[:, None]
        H = share.T @ share + np.diag(self._still)
        n, m = model.nv, len(e)
        system = np.block([[H, J.T], [J, np.zeros((m, m))]])
        objective = share.T @ weight / gravity_of(self._robot)
        tangent = np.linalg.solve(system, np.append(objective, rise))
        return np.asarray(tangent[:n])

    def _rows(self, q: np.ndarray, height: float, upright: bool) -> tuple[np.ndarray, np.ndarray]:
        """Jacobian (18, nv) and error (18,): soles, CoM, roll and yaw, pitch or momentum."""
        model, data = self._model, self._data
        momentum = pin.computeCentroidalMap(model, data, q)
        J_com = pin.jacobianCenterOfMass(model, data, q)
        com = data.com[0].copy()
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J, e = [], []
        for i, wanted in zip(self._ids, self._soles, strict=True):
            J.append(pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED))
            e.append(wanted.translation - data.oMf[i].translation)
            e.append(pin.log3(wanted.rotation @ data.oMf[i].rotation.T))
        J.append(J_com)
        e.append(np.array([*self._middle[:2], height]) - com)
        base = data.oMi[1].rotation
        turn = np.zeros((3, model.nv))
        turn[:, 3:6] = base
        error = pin.log3(self._base @ base.T)
        J.append(turn[[0, 2]])
        e.append(error[[0, 2]])
        J.append(turn[1:2] if upright else _MOMENTUM_SCALE * momentum[4:5])
        e.append(error[1:2] if upright else np.zeros(1))
        return np.vstack(J), np.concatenate(e)
