"""The posture solver: inverse kinematics of a whole posture, as bounded nonlinear least squares.

It works on a `pin.Model`, because loading a robot needs it too: the nominal posture comes from
here, as do the postures of `wbc.ik.PostureIK` and the path of a jump.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pinocchio as pin

_MIN_DAMPING, _MAX_DAMPING = 1e-6, 1e6
_AT_BOUND = 1e-9  # rad
_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class PostureTerm(Protocol):
    """One residual of the posture solver: a weighted error and its Jacobian."""

    @property
    def weight(self) -> float | np.ndarray:
        """Weight of the squared error, for all rows or per row (m,)."""

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the Jacobian (m, nv) of the value and the error (m,), target minus value.

        Args:
            model: the robot's model.
            data: data with frames, CoM and their Jacobians at q.
            q: (nq,) posture.
        """


@dataclass(frozen=True)
class PoseTerm:
    """A frame at a placement in the world; errors in m and rad.

    Attributes:
        frame: id of the frame.
        target: placement of the frame in the world.
        weight: weight of the squared error.
    """

    frame: int
    target: pin.SE3
    weight: float | np.ndarray = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        now = data.oMf[self.frame]
        rotation = pin.log3(self.target.rotation @ now.rotation.T)
        error = np.concatenate((self.target.translation - now.translation, rotation))
        return pin.getFrameJacobian(model, data, self.frame, _WORLD), error


@dataclass(frozen=True)
class PositionTerm:
    """The origin of a frame at a position in the world; error in m.

    Attributes:
        frame: id of the frame.
        target: (3,) position, m.
        weight: weight of the squared error.
    """

    frame: int
    target: np.ndarray
    weight: float | np.ndarray = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        J = pin.getFrameJacobian(model, data, self.frame, _WORLD)[:3]
        return J, self.target - data.oMf[self.frame].translation


@dataclass(frozen=True)
class RotationTerm:
    """A frame in an orientation; error as a rotation vector about world axes, rad.

    Attributes:
        frame: id of the frame.
        target: (3, 3) orientation of the frame in the world.
        weight: weight of the squared error.
        axes: the world axes that count.
    """

    frame: int
    target: np.ndarray
    weight: float | np.ndarray = 1.0
    axes: tuple[int, ...] = (0, 1, 2)

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        axes = list(self.axes)
        J = pin.getFrameJacobian(model, data, self.frame, _WORLD)[3:]
        return J[axes], pin.log3(self.target @ data.oMf[self.frame].rotation.T)[axes]


@dataclass(frozen=True)
class ComTerm:
    """The centre of mass at a position in the world; error in m.

    Attributes:
        target: (3,) position, m.
        weight: weight of the squared error.
    """

    target: np.ndarray
    weight: float | np.ndarray = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        return data.Jcom.copy(), self.target - data.com[0]


@dataclass(frozen=True)
class JointTerm:
    """A joint at a position; error in rad or m.

    Attributes:
        index: index of the joint into velocities (nv,).
        target: position, rad or m.
        weight: weight of the squared error.
    """

    index: int
    target: float
    weight: float | np.ndarray = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        J = np.zeros((1, model.nv))
        J[0, self.index] = 1.0
        return J, np.array([self.target - q[self.index + 1]])


@dataclass(frozen=True)
class NearPostureTerm:
    """The whole posture near a given one, `q_target ⊖ q`.

    Attributes:
        target: (nq,) posture.
        weight: (nv,) weights of the squared error, or one for all.
    """

    target: np.ndarray
    weight: float | np.ndarray

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """See `PostureTerm.rows`."""
        return np.eye(model.nv), pin.difference(model, q, self.target)


class PostureSolver:
    """Levenberg-Marquardt on weighted squares, with joints held at their bounds.

        min ½ Σ wᵢ |eᵢ(q)|²,   lower ≤ q_joints ≤ upper

    (Marquardt, An algorithm for least-squares estimation of nonlinear parameters, 1963.) A joint
    stays at its bound as long as the step pushes against it.

    Args:
        model: the robot's model; joints of one degree of freedom on a free-flyer.
        lower: (na,) least joint positions, rad or m.
        upper: (na,) greatest joint positions, rad or m.
        max_iterations: most evaluations of the terms.
        max_step: largest joint step of an iteration, rad: full steps overshoot near a straight
            knee.
        tolerance: the search ends with a step whose entries are below this, rad and m.
        least_progress: the search ends with a step that takes less than this share off the sum of
            the squares.

    Attributes:
        data: Pinocchio's data; after `solve` and `update` with frames, CoM and Jacobians.
    """

    def __init__(
        self,
        model: pin.Model,
        lower: np.ndarray,
        upper: np.ndarray,
        *,
        max_iterations: int = 120,
        max_step: float = math.inf,
        tolerance: float = 1e-7,
        least_progress: float = 0.0,
    ) -> None:
        self._model, self.data = model, model.createData()
        self._lower, self._upper = lower, upper
        self._max_iterations, self._max_step = max_iterations, max_step
        self._tolerance, self._least_progress = tolerance, least_progress

    def update(self, q: np.ndarray) -> None:
        """Compute frames, CoM and their Jacobians of a posture (nq,) into `data`."""
        pin.computeJointJacobians(self._model, self.data, q)
        pin.updateFramePlacements(self._model, self.data)
        pin.jacobianCenterOfMass(self._model, self.data, q)

    def solve(
        self, start: np.ndarray, free: np.ndarray, terms: Sequence[PostureTerm]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the posture that minimises the terms, searched for from a start.

        Args:
            start: (nq,) posture.
            free: (nv,) which coordinates may move.
            terms: the residuals.

        Returns:
            The posture (nq,), and which of the free coordinates (nv,) are held at a bound.
        """
        q, fixed = np.array(start, dtype=float), ~free
        self._keep_within(q, free[6:])
        blocks = self._rows(q, terms)
        weights = np.concatenate(
            [np.broadcast_to(t.weight, e.shape) for t, (_, e) in zip(terms, blocks, strict=True)]
        )
        cost, H, g = _normal_equations(blocks, weights)
        damping, held = _MIN_DAMPING, fixed
        for _ in range(self._max_iterations):
            step, held = self._step(q, H + damping * np.eye(g.size), g, fixed)
            largest = float(np.abs(step[6:]).max())
            if largest > self._max_step:
                step *= self._max_step / largest
            trial = pin.integrate(self._model, q, step)
            self._keep_within(trial, free[6:])
            new_cost, new_H, new_g = _normal_equations(self._rows(trial, terms), weights)
            if new_cost > cost:
                damping *= 10.0
                if damping > _MAX_DAMPING or float(np.abs(step).max()) < self._tolerance:
                    break
                continue
            progress = cost - new_cost
            q, cost, H, g = trial, new_cost, new_H, new_g
            damping = max(damping * 0.2, _MIN_DAMPING)
            if float(np.abs(step).max()) < self._tolerance:
                break
            if progress < self._least_progress * cost:
                break
        self.update(q)
        return q, held & free

    def _keep_within(self, q: np.ndarray, free_joints: np.ndarray) -> None:
        q[7:][free_joints] = np.clip(q[7:], self._lower, self._upper)[free_joints]

    def _rows(
        self, q: np.ndarray, terms: Sequence[PostureTerm]
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return Jacobian and error of each term at q."""
        self.update(q)
        return [term.rows(self._model, self.data, q) for term in terms]

    def _step(
        self, q: np.ndarray, H: np.ndarray, g: np.ndarray, fixed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the step with those joints held that would leave their range, and which."""
        held = fixed.copy()
        while True:
            free = ~held
            step = np.zeros(g.size)
            step[free] = np.linalg.solve(H[np.ix_(free, free)], g[free])
            after = q[7:] + step[6:]
            beyond = ((q[7:] <= self._lower + _AT_BOUND) & (after < self._lower)) | (
                (q[7:] >= self._upper - _AT_BOUND) & (after > self._upper)
            )
            new = np.concatenate((np.zeros(6, dtype=bool), beyond)) & free
            if not new.any():
                return step, held
            held |= new


def _normal_equations(
    blocks: Sequence[tuple[np.ndarray, np.ndarray]], w: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return half the weighted squares' sum, its Gauss-Newton Hessian, and JᵀW e."""
    J = np.vstack([block for block, _ in blocks])
    e = np.concatenate([error for _, error in blocks])
    JtW = J.T * w
    return 0.5 * float(e @ (w * e)), JtW @ J, JtW @ e
