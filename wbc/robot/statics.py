"""Statics of a robot that stands: contact wrenches and joint torques that hold a posture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

LEVER = 0.1  #: m, makes moments comparable to forces


def smallest_wrenches(jacobian: np.ndarray, force: np.ndarray, lever: float = LEVER) -> np.ndarray:
    """Return the smallest contact wrenches that exert a generalised force on the base.

    They minimise `Σ |fᵢ|² + |mᵢ|² / lever²` subject to `J_bᵀ f = force` (least squares if it has
    no solution).

    Args:
        jacobian: (6k, nv) Jacobians of k contact frames, one below the other.
        force: (6,) or (6, n) generalised forces on the base, N and N·m.
        lever: length that makes moments comparable to forces, m.

    Returns:
        (6k,) or (6k, n) forces and moments at the frames, N and N·m.
    """
    contacts = len(jacobian) // 6
    scale = np.tile([1.0, 1.0, 1.0, lever, lever, lever], contacts)
    scaled = np.linalg.lstsq(jacobian[:, :6].T * scale, force, rcond=None)[0]
    return np.asarray((scaled.T * scale).T)


def holding_torques(model: pin.Model, q: np.ndarray, frames: Sequence[int]) -> np.ndarray:
    """Return the joint torques that hold a posture at rest, `τ = g(q) − Jᵀ f`.

    The contact wrenches f are the smallest that carry the weight; see `smallest_wrenches`.

    Args:
        model: the robot's model.
        q: (nq,) posture.
        frames: ids of the frames on the ground.

    Returns:
        (na,) joint torques, N·m.
    """
    data = model.createData()
    gravity = pin.computeGeneralizedGravity(model, data, q)
    pin.computeJointJacobians(model, data, q)
    J = np.vstack([pin.computeFrameJacobian(model, data, q, f, pin.LOCAL) for f in frames])
    wrenches = smallest_wrenches(J, gravity[:6])
    return np.asarray(gravity[6:] - J[:, 6:].T @ wrenches)
