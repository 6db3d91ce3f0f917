"""Non-physical inertias and massless links: detection and repair.

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

from wbc.errors import RobotDescriptionError

# Smallest radius of gyration, m, that a repaired body is given along any axis.
MIN_GYRATION = 1e-3
# Rounding in a printed URDF breaks the inequality by this much without meaning it.
TOLERANCE = 1e-6
# Inertia about its own axis below which what hangs on a joint counts as massless, kg·m².
# A finger of 1 g and 1 mm gyration has 1e-9.
MIN_INERTIA = 1e-10
# A milligram, spread over a centimetre: far below what any sensor or motor notices.
PLACEHOLDER_MASS = 1e-6
PLACEHOLDER_INERTIA = 1e-10


def is_physical(mass: float, inertia: np.ndarray, tolerance: float = TOLERANCE) -> bool:
    """Whether a rigid body can have this mass (kg) and inertia (3, 3) about its centre (kg·m²)."""
    if not (np.isfinite(mass) and np.isfinite(inertia).all()) or mass <= 0.0:
        return False
    trace = float(np.trace(inertia))
    moments = np.linalg.eigvalsh(inertia)
    second = np.linalg.eigvalsh(0.5 * trace * np.eye(3) - inertia)
    slack = tolerance * max(trace, 0.0)
    return bool(moments[0] > 0.0 and second[0] >= -slack)


def physical_inertia(mass: float, inertia: np.ndarray) -> np.ndarray:
    """Return the physical inertia (3, 3) closest to the given one, kg·m²."""
    second = 0.5 * float(np.trace(inertia)) * np.eye(3) - inertia
    values, axes = np.linalg.eigh(second)
    clipped = np.maximum(values, mass * MIN_GYRATION**2)
    second = axes @ np.diag(clipped) @ axes.T
    return np.asarray(float(np.trace(second)) * np.eye(3) - second)


def repair_model(model: pin.Model) -> list[int]:
    """Make every moving body of the model physical; return the ids of the joints that changed.

    Bodies without mass are left unchanged; `check_mass_matrix` tells whether they matter.
    """
    changed = []
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        if body.mass <= 0.0 or is_physical(body.mass, body.inertia):
            continue
        model.inertias[joint] = pin.Inertia(
            body.mass, body.lever, physical_inertia(body.mass, body.inertia)
        )
        changed.append(joint)
    return changed


def massless_joints(model: pin.Model, q: np.ndarray) -> list[tuple[str, float]]:
    """Return (joint, inertia) of each joint that moves almost no inertia about its own axis.

    The diagonal of the mass matrix without armature, kg·m² (kg for sliding
    joints): armature would hide the defect from the inverse, but not from a physics engine.
    """
    bare = model.copy()
    bare.armature = np.zeros(model.nv)
    diagonal = np.diag(pin.crba(bare, bare.createData(), q))
    return [
        (model.names[joint], float(diagonal[model.joints[joint].idx_v]))
        for joint in range(2, model.njoints)
        if not diagonal[model.joints[joint].idx_v] > MIN_INERTIA
    ]


def add_placeholder_masses(model: pin.Model) -> None:
    """Give a milligram to each moving body that has no mass.

    Descriptions put massless links between the axes of a ball joint. The mass matrix stays
    regular, but a physics engine refuses a moving body without mass.
    """
    for joint in range(1, model.njoints):
        if model.inertias[joint].mass <= 0.0:
            model.inertias[joint] = pin.Inertia(
                PLACEHOLDER_MASS, np.zeros(3), PLACEHOLDER_INERTIA * np.eye(3)
            )


def check_mass_matrix(model: pin.Model, q: np.ndarray, source: str) -> None:
    """Refuse a model whose mass matrix (nv, nv) is not positive definite at `q` (nq,).

    Raises:
        RobotDescriptionError: names the joints and the links that need inertia.
    """
    bad = massless_joints(model, q)
    if bad:
        listed = ", ".join(f"'{name}' (moves {_bodies(model, name)})" for name, _ in bad)
        raise RobotDescriptionError(
            f"{source}: the joints {listed} move nothing that has inertia, so the mass matrix "
            "is singular and accelerations are undefined; give those links an <inertial> "
            "with mass and inertia, or make the joints fixed"
        )
    M = pin.crba(model, model.createData(), q)
    try:
        if not np.isfinite(M).all():
            raise np.linalg.LinAlgError
        np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        raise RobotDescriptionError(
            f"{source}: the mass matrix is not positive definite (total mass "
            f"{pin.computeTotalMass(model):.3g} kg); give every link a physical <inertial>"
        ) from None


def _bodies(model: pin.Model, joint: str) -> str:
    moved = set(model.subtrees[model.getJointId(joint)])
    links = [f.name for f in model.frames if f.type == pin.BODY and f.parentJoint in moved]
    more = f" and {len(links) - 3} more links" if len(links) > 3 else ""
    return "link " + ", ".join(f"'{link}'" for link in links[:3]) + more
