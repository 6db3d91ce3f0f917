"""The base of limits on single joints: bounds on their accelerations."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics


class AccelerationBound(ABC):
    """A limit that becomes a bound on each joint's acceleration, `lower ≤ q̈ ≤ upper`.

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

    def __repr__(self) -> str:
        return f"{type(self).__name__}({f'horizon {self.horizon:g} s' if self.horizon else ''})"

    @abstractmethod
    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """Return the least and the largest joint acceleration, (na,) rad/s² each.

        Bounds of one limit do not exclude each other: lower ≤ upper.
        """

    def velocity_bounds(
        self, kin: Kinematics, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the least and the largest joint velocity of a step, (na,) rad/s each.

        Unless overridden, those that follow from `bounds` within dt.

        Args:
            kin: kinematics of a state at rest.
            v: (na,) joint velocities before the step, rad/s.
            dt: duration of the step, s.
        """
        lower, upper = self.bounds(kin)
        return v + dt * lower, v + dt * upper
