"""Inertias that no rigid body can have, made physical.

A rotational inertia `I` (3, 3) about the centre of mass, kg·m², is physical if
the second moment of its mass

    Σ = tr(I)/2 · 1 − I        (3, 3), kg·m²

is positive definite, which says at once that `I` is and that its principal
moments obey the triangle inequality (Wensing, Kim and Slotine, "Linear matrix
inequalities for physically consistent inertial parameter identification",
IEEE RA-L 3(1), 2018). The nearest physical inertia clips the eigenvalues of Σ.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

# Smallest radius of gyration, m, that a repaired body is given along any axis.
MIN_GYRATION = 1e-3
# Rounding in a printed URDF breaks the inequality by this much without meaning it.
TOLERANCE = 1e-6


def is_physical(mass: float, inertia: np.ndarray, tolerance: float = TOLERANCE) -> bool:
    """Whether a mass (kg) and an inertia (3, 3) at its centre (kg·m²) can be a rigid body's."""
    if not (np.isfinite(mass) and np.isfinite(inertia).all()) or mass <= 0.0:
        return False
    trace = float(np.trace(inertia))
    moments = np.linalg.eigvalsh(inertia)
    second = np.linalg.eigvalsh(0.5 * trace * np.eye(3) - inertia)
    slack = tolerance * max(trace, 0.0)
    return bool(moments[0] > 0.0 and second[0] >= -slack)


def repaired(mass: float, inertia: np.ndarray) -> np.ndarray:
    """The physical inertia (3, 3) nearest to the given one, kg·m²."""
    second = 0.5 * float(np.trace(inertia)) * np.eye(3) - inertia
    values, axes = np.linalg.eigh(second)
    clipped = np.maximum(values, mass * MIN_GYRATION**2)
    second = axes @ np.diag(clipped) @ axes.T
    return np.asarray(float(np.trace(second)) * np.eye(3) - second)


def repair_model(model: pin.Model) -> list[int]:
    """Make every moving body of the model physical; ids of the joints whose body changed.

    A body without any mass is left alone: whether the model can do without it
    is for the mass matrix to say.
    """
    changed = []
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        if body.mass <= 0.0 or is_physical(body.mass, body.inertia):
            continue
        model.inertias[joint] = pin.Inertia(
            body.mass, body.lever, repaired(body.mass, body.inertia)
        )
        changed.append(joint)
    return changed
