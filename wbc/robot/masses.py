"""Whether a model's mass matrix can be inverted, and if not, because of which link."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError

# Inertia about its own axis below which what hangs on a joint counts as massless, kg·m².
# A finger of 1 g and 1 mm gyration has 1e-9.
LEAST_INERTIA = 1e-10
# A milligram, spread over a centimetre: far below what any sensor or motor notices.
SPECK_MASS = 1e-6
SPECK_INERTIA = 1e-10


def massless_joints(model: pin.Model, q: np.ndarray) -> list[tuple[str, float]]:
    """(joint, inertia) of each joint that moves next to no inertia about its own axis.

    The diagonal of the mass matrix without armature, kg·m² (kg for sliding
    joints): armature would hide the defect from the inverse, not from a plant.
    """
    bare = model.copy()
    bare.armature = np.zeros(model.nv)
    diagonal = np.diag(pin.crba(bare, bare.createData(), q))
    return [
        (model.names[joint], float(diagonal[model.joints[joint].idx_v]))
        for joint in range(2, model.njoints)
        if not diagonal[model.joints[joint].idx_v] > LEAST_INERTIA
    ]


def fill_massless(model: pin.Model) -> None:
    """Give a speck of mass to the moving bodies that have none.

    Descriptions put massless links between the axes of a ball joint. The mass
    matrix does not mind, but a physics engine refuses a moving body without mass.
    """
    for joint in range(1, model.njoints):
        if model.inertias[joint].mass <= 0.0:
            model.inertias[joint] = pin.Inertia(SPECK_MASS, np.zeros(3), SPECK_INERTIA * np.eye(3))


def check_mass_matrix(model: pin.Model, q: np.ndarray, source: str) -> None:
    """Refuse a model whose mass matrix (nv, nv) is not positive definite at `q` (nq,).

    Raises:
        RobotDescriptionError: names the joints and the links that need inertia.
    """
    bad = massless_joints(model, q)
    if bad:
        listed = ", ".join(f"'{name}' (moves {_bodies(model, name)})" for name, _ in bad)
        raise RobotDescriptionError(
            f"{source}: nothing with inertia hangs on the joints {listed}, so the mass matrix "
            "is singular and accelerations are undefined; give those links an <inertial> "
            "with mass and inertia, or make the joints fixed"
        )
    M = pin.crba(model, model.createData(), q)
    M = np.triu(M) + np.triu(M, 1).T
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
