"""Soft ground: the soles sink into it until it carries the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Constraint impedance of soft contacts (MuJoCo's solimp): half of a spring's, half of a
#: constraint's. Near 1 the depth of a contact does not depend on its load, near 0 it creeps.
_IMPEDANCE = 0.5
#: Friction stays that much stiffer than the normal force (MuJoCo's impratio): soft ground yields
#: under the soles but does not let them slide.
_FRICTION_STIFFNESS = 100.0


def soften_ground(
    mujoco: Any, model: Any, standing: np.ndarray, sink: float, weight: float
) -> None:
    """Make all ground geoms so soft that the standing robot sinks in by about `sink`.

    In MuJoCo a contact of impedance d and effective mass 1/A carries the force f at the depth
    r = (1 − d)/d² · A f / k, with k = 1/(d² T²) for the time constant T (its documentation,
    "Solver parameters"). T follows from the depth, the contact's A in the standing posture and
    its share of the weight. The ground is critically damped.

    Args:
        mujoco: the module.
        model: its model, changed in place.
        standing: (nq,) MuJoCo's qpos of the standing robot.
        sink: depth, m.
        weight: N.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = standing
    data.qpos[2] -= 1e-4  # in contact, whatever rounding does
    mujoco.mj_forward(model, data)
    inverse_mass = float(np.mean(data.efc_diagA[data.contact.efc_address]))
    d, force = _IMPEDANCE, weight / data.ncon
    k = (1.0 - d) / d**2 * inverse_mass * force / sink
    ground = np.flatnonzero(model.body_weldid[model.geom_bodyid] == 0)
    mocap = np.flatnonzero(model.body_mocapid[model.geom_bodyid] >= 0)
    for geom in {*ground.tolist(), *mocap.tolist()}:
        model.geom_solref[geom] = [1.0 / (d * np.sqrt(k)), 1.0]
        model.geom_solimp[geom] = [d, d, 0.001, 0.5, 2.0]
        model.geom_priority[geom] = 1
    model.opt.impratio = _FRICTION_STIFFNESS
