"""The bases of all limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.robot import Robot


class AccelerationBound(ABC):
    """A limit that becomes a box on the joint accelerations."""

    name: ClassVar[str]
    unit: ClassVar[str] = "rad/s²"

    @abstractmethod
    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """(na,) least and largest joint acceleration, rad/s²; never lower > upper."""


def per_joint(name: str, what: str, value: float | np.ndarray, robot: Robot) -> np.ndarray:
    """A number or (na,) array of positive limits as (na,).

    Raises:
        LimitError: wrong shape, or an entry that is not positive.
    """
    array = np.asarray(value, dtype=float)
    if array.ndim == 0:
        array = np.full(robot.na, float(array))
    if array.shape != (robot.na,):
        raise LimitError(f"{name}: {what} has shape {array.shape}, expected a number or ({robot.na},)")
    bad = np.flatnonzero(~(array > 0.0))
    if bad.size:
        joint = robot.joint_names[int(bad[0])]
        raise LimitError(f"{name}: {what} of '{joint}' is {array[bad[0]]}, it must be positive")
    return array
