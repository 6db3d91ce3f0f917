"""Inverse kinematics of standing: soles flat on one plane, base upright.

A damped Gauss–Newton iteration over the base and the leg joints. It runs once,
when a robot is loaded, and is no controller.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pinocchio as pin

ITERATIONS = 80
DAMPING = 1e-6
POSTURE_WEIGHT = 1e-3
JOINT_WEIGHT = 1.0
# Largest joint step of one iteration, rad: Gauss–Newton overshoots near a straight knee.
STEP = 0.2
CONVERGED = 1e-10
# Kept free of each joint's range at its ends, rad: nobody should stand in a stop.
MARGIN = 0.02


def settle(
    model: pin.Model,
    q: np.ndarray,
    soles: tuple[int, int],
    move: Iterable[int],
    *,
    joints: Mapping[int, float] | None = None,
    align: bool = False,
    over_soles: bool = False,
) -> np.ndarray:
    """A standing posture near `q` (nq,).

    Args:
        model: the robot.
        q: (nq,) where to start, base orientation included, which is kept.
        soles: frame ids of the left and right sole.
        move: velocity indices (nv) of the joints that may move.
        joints: velocity index to wanted position, rad.
        align: also bring the soles beside each other, pointing along x.
        over_soles: also bring the centre of mass over the soles' midpoint.
    """
    data = model.createData()
    # The base moves but does not turn: upright is what the posture means by it.
    free = np.array([0, 1, 2, *sorted(move)])
    lower, upper = posture_range(model)
    # A posture that starts inside the margin may stay there, but not beyond the limits.
    lower = np.maximum(np.minimum(lower, q[7:]), model.lowerPositionLimit[7:])
    upper = np.minimum(np.maximum(upper, q[7:]), model.upperPositionLimit[7:])
    joint_entries = free[3:] + 1
    lower, upper = lower[joint_entries - 7], upper[joint_entries - 7]
    q0, q = np.array(q), np.array(q)
    # First near the given posture, then without that pull, which would leave an error.
    for pull in (POSTURE_WEIGHT, 0.0):
        for _ in range(ITERATIONS):
            rows, errors = _sole_rows(model, data, q, soles, align)
            if over_soles:
                J_com = pin.jacobianCenterOfMass(model, data, q)
                middle, J_middle = _middle(model, data, soles)
                rows.append(J_com[:2] - J_middle[:2])
                errors.append(middle[:2] - data.com[0][:2])
            for index, wanted in (joints or {}).items():
                rows.append(JOINT_WEIGHT * np.eye(model.nv)[index : index + 1])
                errors.append(np.array([JOINT_WEIGHT * (wanted - q[index + 1])]))
            rows.append(pull * np.eye(model.nv))
            errors.append(pull * pin.difference(model, q, q0))
            J, e = np.vstack(rows)[:, free], np.concatenate(errors)
            dq = np.zeros(model.nv)
            dq[free] = np.linalg.solve(J.T @ J + DAMPING * np.eye(len(free)), J.T @ e)
            dq *= min(1.0, STEP / max(float(np.abs(dq[6:]).max()), 1e-12))
            q = pin.integrate(model, q, dq)
            q[joint_entries] = np.clip(q[joint_entries], lower, upper)
            if np.abs(dq).max() < CONVERGED:
                break
    return q


def unevenness(model: pin.Model, q: np.ndarray, soles: tuple[int, int]) -> tuple[float, float]:
    """Largest tilt of a sole (rad) and height between the soles (m) at a posture."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    normals = [data.oMf[sole].rotation[:, 2] for sole in soles]
    tilt = max(float(np.arctan2(np.hypot(n[0], n[1]), n[2])) for n in normals)
    left, right = (data.oMf[sole].translation for sole in soles)
    return tilt, abs(float(left[2] - right[2]))


def posture_range(model: pin.Model) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest joint position (na,) that a posture uses: the limits less a margin."""
    lower, upper = model.lowerPositionLimit[7:], model.upperPositionLimit[7:]
    with np.errstate(invalid="ignore"):
        margin = np.where(np.isfinite(upper - lower), 0.05 * (upper - lower), 0.0)
    margin = np.minimum(margin, MARGIN)
    return lower + margin, upper - margin


def _middle(
    model: pin.Model, data: pin.Data, soles: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    points = [data.oMf[sole].translation for sole in soles]
    jacobians = [
        pin.getFrameJacobian(model, data, sole, pin.LOCAL_WORLD_ALIGNED)[:3] for sole in soles
    ]
    return 0.5 * (points[0] + points[1]), 0.5 * (jacobians[0] + jacobians[1])


def _sole_rows(
    model: pin.Model, data: pin.Data, q: np.ndarray, soles: tuple[int, int], align: bool
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    middle, J_middle = _middle(model, data, soles)
    rows, errors = [], []
    for sole in soles:
        T = data.oMf[sole]
        J = pin.getFrameJacobian(model, data, sole, pin.LOCAL_WORLD_ALIGNED)
        # n × z turns the sole's normal n upright.
        tilt = np.cross(T.rotation[:, 2], [0.0, 0.0, 1.0])
        rows += [J[3:5], J[2:3]]
        errors += [tilt[:2], -T.translation[2:3]]
        if align:
            yaw = np.arctan2(T.rotation[1, 0], T.rotation[0, 0])
            rows += [J[5:6], J[0:1] - J_middle[0:1]]
            errors += [np.array([-yaw]), middle[0:1] - T.translation[0:1]]
    return rows, errors
