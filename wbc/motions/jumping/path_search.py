"""Search for the path of a jump: inverse kinematics without angular momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.motions.jumping.path import JumpPath
from wbc.robot import Robot
from wbc.robot.posture_solver import (
    ComTerm,
    PoseTerm,
    PostureSolver,
    PostureTerm,
    RotationTerm,
)

_POINTS = 33
_SUBSTEPS = 2
_MIN_POINTS = 3
_REACHED = 1e-6  # m, rad
_TOLERANCE = 1e-10  # m, rad
_MAX_ITERATIONS = 60
_MAX_STEP = 0.2  # rad
_MARGIN = 0.05  # rad that the legs keep from their position limits
_MOMENTUM_SCALE = 0.1  # makes momentum rows comparable to lengths
_COM_HEIGHT_ROW = 14  # of the rows of all terms: after two poses and the CoM's x and y


def find_path(robot: Robot, top: float, depth: float, arm_weight: float) -> JumpPath | None:
    """Return the path down from the CoM height at which the trunk is upright; None if too high.

    The path ends where a leg's joint comes near its position limit, if not before.

    Args:
        robot: the robot.
        top: greatest height of the CoM above the soles, m.
        depth: length of the path, downwards, m.
        arm_weight: weight of (dq/dz)² of waist and arms against the squares of their torque
            shares per m/s²: with less they swing more, and take less torque in flight.
    """
    search = _PathSearch(robot, arm_weight)
    path = search.run(np.linspace(top - depth, top, _POINTS))
    if path is not None and len(path.height) < _POINTS:  # the same resolution on a shorter path
        path = search.run(np.linspace(float(path.height[0]), top, _POINTS))
    return path


@dataclass(frozen=True)
class _PitchMomentumTerm:
    """No change of the angular momentum about y: a row without an error."""

    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        momentum = pin.computeCentroidalMap(model, data, q)
        return _MOMENTUM_SCALE * momentum[4:5], np.zeros(1)


class _PathSearch:
    """Follows the path down from its upper end."""

    def __init__(self, robot: Robot, arm_weight: float) -> None:
        self._robot, self._model = robot, robot.model
        unbounded = np.full(robot.na, np.inf)
        self._solver = PostureSolver(
            robot.model,
            -unbounded,
            unbounded,
            max_iterations=_MAX_ITERATIONS,
            max_step=_MAX_STEP,
            tolerance=_TOLERANCE,
        )
        self._data = data = self._solver.data
        self._legs = np.array(sorted(i for leg in robot.legs for i in leg))
        self._free = np.zeros(robot.nv, dtype=bool)
        self._free[:6] = self._free[self._legs] = True
        self._others = np.flatnonzero(~self._free)
        self._arm_weights = np.zeros(robot.nv)
        self._arm_weights[self._others] = arm_weight
        self._solver.update(robot.q_nominal)
        self._trunk = [robot.frame_id(name) for name in (robot.torso, robot.base)]
        self._upright = [data.oMf[i].rotation.copy() for i in self._trunk]
        soles = [sole.frame_id for sole in robot.soles]
        self._soles = [PoseTerm(i, data.oMf[i].copy()) for i in soles]
        self._middle = 0.5 * (data.oMf[soles[0]].translation + data.oMf[soles[1]].translation)

    def run(self, heights: np.ndarray) -> JumpPath | None:
        """Return the path through CoM heights (n,), ascending, m; None if the last is too high."""
        q = self._solve(self._robot.q_nominal, self._terms(heights[-1], upright=True))
        if q is None:
            return None
        configurations, tangents = [q], [self._tangent(q)]
        for k in range(len(heights) - 2, -1, -1):
            step = (heights[k] - heights[k + 1]) / _SUBSTEPS
            for _ in range(_SUBSTEPS):
                middle = pin.integrate(self._model, q, 0.5 * step * self._tangent(q))
                q = pin.integrate(self._model, q, step * self._tangent(middle))
            q, _ = self._solver.solve(q, self._free, self._terms(heights[k], upright=False))
            if not self._within_limits(q):
                break
            configurations.append(q)
            tangents.append(self._tangent(q))
        if len(tangents) < _MIN_POINTS:
            return None
        height = heights[-len(tangents) :]
        q_all, tangent = np.array(configurations[::-1]), np.array(tangents[::-1])
        curvature = np.asarray(np.gradient(tangent, height, axis=0))
        force = np.array([self._force(*row) for row in zip(q_all, tangent, curvature, strict=True)])
        pitch = np.array([self._pitch(q) for q in q_all])
        return JumpPath(self._robot, height, q_all, tangent, curvature, pitch, force)

    def _terms(self, height: float, *, upright: bool) -> list[PostureTerm]:
        """Return soles, CoM, roll and yaw of the base; then its pitch, or angular momentum."""
        base, rotation = self._trunk[1], self._upright[1]
        last = RotationTerm(base, rotation, axes=(1,)) if upright else _PitchMomentumTerm()
        com = ComTerm(np.array([*self._middle[:2], height]))
        return [*self._soles, com, RotationTerm(base, rotation, axes=(0, 2)), last]

    def _solve(self, start: np.ndarray, terms: list[PostureTerm]) -> np.ndarray | None:
        """Return the posture that meets the terms with base and legs; None if there is none."""
        q, _ = self._solver.solve(start, self._free, terms)
        errors = (term.rows(self._model, self._data, q)[1] for term in terms)
        return q if max(float(np.abs(e).max()) for e in errors) <= _REACHED else None

    def _within_limits(self, q: np.ndarray) -> bool:
        robot = self._robot
        distance = np.minimum(q[7:] - robot.q_min, robot.q_max - q[7:])[self._legs - 6]
        return bool((distance > _MARGIN).all())

    def _pitch(self, q: np.ndarray) -> list[float]:
        self._solver.update(q)
        return [
            float(pin.log3(self._data.oMf[i].rotation @ R.T)[1])
            for i, R in zip(self._trunk, self._upright, strict=True)
        ]

    def _force(self, q: np.ndarray, tangent: np.ndarray, curvature: np.ndarray) -> np.ndarray:
        """Return the columns a, b, c of `JumpPath.force`, (nv, 3)."""
        model, data, zero = self._model, self._data, np.zeros(self._model.nv)
        gravity = pin.rnea(model, data, q, zero, zero).copy()
        inertia = pin.rnea(model, data, q, zero, tangent) - gravity
        centrifugal = pin.rnea(model, data, q, tangent, curvature) - gravity
        return np.column_stack((inertia, centrifugal, gravity))

    def _tangent(self, q: np.ndarray) -> np.ndarray:
        """Return q' (nv,): no momentum, and the least torque share of waist and arms in flight.

        There, accelerated by z̈, they take (a − c/g) z̈; see `JumpPath.flight`.
        """
        model, data, others = self._model, self._data, self._others
        self._solver.update(q)
        terms = self._terms(0.0, upright=False)
        J = np.vstack([term.rows(model, data, q)[0] for term in terms])
        rise = np.zeros(len(J))
        rise[_COM_HEIGHT_ROW] = 1.0
        limit = model.effortLimit[others]
        weight = pin.computeGeneralizedGravity(model, data, q)[others] / limit
        M = pin.crba(model, data, q)
        share = M[others] / limit[:, None]
        H = share.T @ share + np.diag(self._arm_weights)
        n, m = model.nv, len(J)
        system = np.zeros((n + m, n + m))
        system[:n, :n], system[:n, n:], system[n:, :n] = H, J.T, J
        target = share.T @ weight / self._robot.gravity
        return np.asarray(np.linalg.solve(system, np.append(target, rise))[:n])
