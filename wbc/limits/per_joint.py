"""Values per joint: their check, and what a joint can be expected to brake with."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel
from wbc.state import State


def per_joint(name: str, what: str, value: float | np.ndarray, robot: RobotModel) -> np.ndarray:
    """Return a number or (na,) array of positive limits as (na,), not to be changed in place.

    Raises:
        LimitError: wrong type or shape, or an entry that is not positive.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise LimitError(
            f"{name}: {what} = {value!r} is neither a number nor an array of them"
        ) from None
    if array.ndim == 0:
        array = np.full(robot.na, float(array))
    if array.shape != (robot.na,):
        raise LimitError(
            f"{name}: {what} has shape {array.shape}, expected a number or ({robot.na},)"
        )
    bad = np.flatnonzero(~(array > 0.0))
    if bad.size:
        joint = robot.joint_names[int(bad[0])]
        raise LimitError(f"{name}: {what} of '{joint}' is {array[bad[0]]}, it must be positive")
    array.setflags(write=False)
    return array


def default_braking(robot: RobotModel) -> np.ndarray:
    """Return the deceleration that a joint can count on, (na,) rad/s².

    It is what half of the joint's torque limit gives the limb beyond it in the nominal posture,
    and at most 20 rad/s².
    """
    inertia = np.diag(Kinematics(robot, State(robot.q_nominal, np.zeros(robot.nv))).mass_matrix)[6:]
    return np.asarray(np.minimum(20.0, 0.5 * robot.tau_max / inertia))
