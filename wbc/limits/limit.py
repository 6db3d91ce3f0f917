"""The bases of all limits."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.robot import Robot


class AccelerationBound(ABC):
    """A limit that becomes a box on the joint accelerations.

    Args:
        horizon: time within which the limit corrects a violation, s; not shorter than the
            control period. Zero for a limit that looks at accelerations only.

    Raises:
        LimitError: the horizon is not positive.
    """

    name: ClassVar[str]
    unit: ClassVar[str] = "rad/s²"
    horizon: float = 0.0

    def __init__(self, horizon: float) -> None:
        if not 0.0 < horizon < math.inf:
            raise LimitError(f"{self.name}: horizon {horizon} s must be positive and finite")
        self.horizon = horizon

    @abstractmethod
    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """(na,) least and largest joint acceleration, rad/s²; never lower > upper."""


def per_joint(name: str, what: str, value: float | np.ndarray, robot: Robot) -> np.ndarray:
    """A number or (na,) array of positive limits as (na,), not to be changed in place.

    Raises:
        LimitError: wrong shape, or an entry that is not positive.
    """
    array = np.array(value, dtype=float)
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


def default_braking(robot: Robot) -> np.ndarray:
    """(na,) acceleration that a joint can count on, rad/s².

    What half of its torque limit gives the limb beyond it in the nominal posture, and at
    most 20 rad/s².
    """
    inertia = np.diag(Kinematics(robot, robot.standing()).mass_matrix)[6:]
    return np.asarray(np.minimum(20.0, 0.5 * robot.tau_max / inertia))
