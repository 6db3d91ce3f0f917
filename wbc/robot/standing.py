"""Standing postures: soles flat on one plane, base upright, found by the posture solver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.robot.couplings import Coupling
from wbc.robot.posture_solver import JointTerm, NearPostureTerm, PostureSolver, PostureTerm

_NEAR_WEIGHT = 1e-6  # of the given posture
_MAX_STEP = 0.2  # rad
_MAX_ITERATIONS = 80
_TOLERANCE = 1e-10  # rad, m
# Margin of postures at the ends of each joint's range, rad: no posture rests on a stop.
_MARGIN = 0.02
_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def standing_posture(
    model: pin.Model,
    q: np.ndarray,
    soles: tuple[int, ...],
    move: Iterable[int],
    couplings: Iterable[Coupling] = (),
    *,
    joints: Mapping[int, float] | None = None,
    align: bool = False,
    over_soles: bool = False,
    apart: float | None = None,
) -> np.ndarray:
    """Return the standing posture near q (nq,), with two flat soles, or four feet on the ground.

    Args:
        model: the robot's model.
        q: (nq,) where to start; its base orientation is kept.
        soles: frame ids of the soles, left first.
        move: indices into velocities (nv,) of the joints that may move.
        couplings: joints that follow others.
        joints: index into velocities -> target position, rad.
        align: also bring the soles beside each other, pointing along x.
        over_soles: also bring the centre of mass over the soles' midpoint.
        apart: also bring the soles to this lateral distance, m, if they are aligned.
    """
    # The base moves but does not turn: upright is what the posture means by it.
    free = np.zeros(model.nv, dtype=bool)
    free[[0, 1, 2, *move]] = True
    lower, upper = posture_range(model)
    # A posture that starts inside the margin may stay there, but not beyond the limits.
    lower = np.maximum(np.minimum(lower, q[7:]), model.lowerPositionLimit[7:])
    upper = np.minimum(np.maximum(upper, q[7:]), model.upperPositionLimit[7:])
    solver = PostureSolver(
        model,
        lower,
        upper,
        max_iterations=_MAX_ITERATIONS,
        max_step=_MAX_STEP,
        tolerance=_TOLERANCE,
    )
    terms: list[PostureTerm] = [
        _FeetOnGround(soles) if on_points(soles) else _FlatSoles(soles, align, apart)
    ]
    if over_soles:
        terms.append(_ComOverSoles(soles))
    terms += [_Coupled(coupling) for coupling in couplings if free[6 + coupling.joint]]
    terms += [JointTerm(index, target) for index, target in (joints or {}).items()]
    # First near the given posture, then without that pull, which would leave an error.
    near, _ = solver.solve(q, free, [*terms, NearPostureTerm(np.array(q), _NEAR_WEIGHT)])
    return solver.solve(near, free, terms)[0]


def feet_below_hips(
    model: pin.Model,
    q: np.ndarray,
    feet: tuple[int, ...],
    hips: Sequence[int],
    move: Iterable[int],
    knees: Mapping[int, float],
    couplings: Iterable[Coupling] = (),
) -> np.ndarray:
    """Return the posture near q (nq,) with level feet, each below its hip as seen from the side.

    Args:
        model: the robot's model.
        q: (nq,) where to start; its base orientation is kept.
        feet: frame ids of the feet.
        hips: ids of the first joints of their legs.
        move: indices into velocities (nv,) of the joints that may move.
        knees: index into velocities -> position of the knee, rad.
        couplings: joints that follow others.
    """
    free = np.zeros(model.nv, dtype=bool)
    free[[2, *move]] = True
    terms: list[PostureTerm] = [_FeetBelowHips(feet, tuple(hips))]
    terms += [JointTerm(index, target) for index, target in knees.items()]
    terms += [_Coupled(coupling) for coupling in couplings if free[6 + coupling.joint]]
    terms.append(NearPostureTerm(np.array(q), _NEAR_WEIGHT))
    solver = PostureSolver(model, *posture_range(model), max_step=_MAX_STEP)
    return solver.solve(q, free, terms)[0]


def unevenness(model: pin.Model, q: np.ndarray, soles: tuple[int, ...]) -> tuple[float, float]:
    """Return the largest tilt of a sole (rad) and the height between the soles (m).

    Four feet are points, which have no tilt.
    """
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    normals = [data.oMf[sole].rotation[:, 2] for sole in soles]
    tilt = max(float(np.arctan2(np.hypot(n[0], n[1]), n[2])) for n in normals)
    if on_points(soles):
        tilt = 0.0
    heights = [float(data.oMf[sole].translation[2]) for sole in soles]
    return tilt, max(heights) - min(heights)


def posture_range(model: pin.Model) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest joint positions (na,) of postures: limits less a margin."""
    lower, upper = model.lowerPositionLimit[7:], model.upperPositionLimit[7:]
    with np.errstate(invalid="ignore"):
        margin = np.where(np.isfinite(upper - lower), 0.05 * (upper - lower), 0.0)
    margin = np.minimum(margin, _MARGIN)
    return lower + margin, upper - margin


@dataclass(frozen=True)
class _FlatSoles:
    """Soles flat on z = 0; if aligned, also side by side, pointing along x, and so far apart."""

    soles: tuple[int, ...]
    align: bool
    apart: float | None = None
    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        middle, J_middle = _middle(model, data, self.soles)
        rows, errors = [], []
        if self.align and self.apart is not None:
            left, right = (data.oMf[sole].translation for sole in self.soles)
            J_left, J_right = (
                pin.getFrameJacobian(model, data, sole, _WORLD)[1:2] for sole in self.soles
            )
            rows, errors = [J_left - J_right], [self.apart - (left - right)[1:2]]
        for sole in self.soles:
            T = data.oMf[sole]
            J = pin.getFrameJacobian(model, data, sole, _WORLD)
            # n × z turns the sole's normal n upright.
            tilt = np.cross(T.rotation[:, 2], [0.0, 0.0, 1.0])
            rows += [J[3:5], J[2:3]]
            errors += [tilt[:2], -T.translation[2:3]]
            if self.align:
                yaw = np.arctan2(T.rotation[1, 0], T.rotation[0, 0])
                rows += [J[5:6], J[0:1] - J_middle[0:1]]
                errors += [np.array([-yaw]), middle[0:1] - T.translation[0:1]]
        return np.vstack(rows), np.concatenate(errors)


def on_points(soles: Sequence[object]) -> bool:
    """Return whether so many feet touch the ground at points: four do, two have soles."""
    return len(soles) > 2


@dataclass(frozen=True)
class _FeetOnGround:
    """Feet on z = 0, however they are turned."""

    feet: tuple[int, ...]
    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        J = [pin.getFrameJacobian(model, data, foot, _WORLD)[2:3] for foot in self.feet]
        return np.vstack(J), np.array([-float(data.oMf[foot].translation[2]) for foot in self.feet])


@dataclass(frozen=True)
class _FeetBelowHips:
    """Feet on z = 0, with the x of their hips."""

    feet: tuple[int, ...]
    hips: tuple[int, ...]
    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        rows, errors = [], []
        for foot, hip in zip(self.feet, self.hips, strict=True):
            way = data.oMi[hip].translation - data.oMf[foot].translation
            J = pin.getFrameJacobian(model, data, foot, _WORLD)
            J_hip = pin.getJointJacobian(model, data, hip, _WORLD)
            rows += [J[0:1] - J_hip[0:1], J[2:3]]
            errors += [float(way[0]), -float(data.oMf[foot].translation[2])]
        return np.vstack(rows), np.array(errors)


@dataclass(frozen=True)
class _ComOverSoles:
    """The centre of mass above the midpoint between the soles."""

    soles: tuple[int, ...]
    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        middle, J_middle = _middle(model, data, self.soles)
        return data.Jcom[:2] - J_middle[:2], middle[:2] - data.com[0][:2]


@dataclass(frozen=True)
class _Coupled:
    """A joint where the one that it follows wants it."""

    coupling: Coupling
    weight: float = 1.0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        coupling = self.coupling
        J = np.zeros((1, model.nv))
        J[0, 6 + coupling.joint] = 1.0
        J[0, 6 + coupling.leader] = -coupling.ratio
        wanted = coupling.ratio * q[7 + coupling.leader] + coupling.offset
        return J, np.array([wanted - q[7 + coupling.joint]])


def _middle(
    model: pin.Model, data: pin.Data, soles: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the midpoint between the soles (3,), m, and its Jacobian (3, nv)."""
    points = [data.oMf[sole].translation for sole in soles]
    jacobians = [pin.getFrameJacobian(model, data, sole, _WORLD)[:3] for sole in soles]
    share = 1.0 / len(soles)
    return share * sum(points[1:], points[0]), share * sum(jacobians[1:], jacobians[0])
