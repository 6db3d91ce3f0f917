"""Motion subspaces of a model's joints."""

from __future__ import annotations

import numpy as np
import pinocchio as pin


def joint_axes(model: pin.Model) -> list[np.ndarray]:
    """Return the motion subspace of each joint, (6,), linear first; zeros unless it has one DoF.

    Args:
        model: the model; the list has one entry per joint id.
    """
    axes = []
    for joint in model.joints:
        if joint.nv != 1:
            axes.append(np.zeros(6))
            continue
        data = joint.createData()
        joint.calc(data, np.zeros(model.nq) if joint.nq == 1 else pin.neutral(model))
        axes.append(np.asarray(data.S).reshape(6))
    return axes
