"""The base of general limits: named rows between bounds."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel

if TYPE_CHECKING:
    from wbc.contacts import Contact


@dataclass(frozen=True, slots=True, eq=False)
class LimitRows:
    """The rows of a `Limit`: `lower ≤ A v̇ + Σ F_c f_c ≤ upper`, the sum over the contacts c.

    Before each tick A and F are zero and the bounds infinite, so that rows that are not written
    do not constrain anything.

    Attributes:
        A: (m, nv) coefficients of the generalised acceleration.
        lower: (m,) least value, −∞ for none.
        upper: (m,) largest value, ∞ for none.
        forces: contact → (m, motion_size) coefficients F_c of its force, contact axes; the
            present contacts, so that it is empty in free fall.
    """

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    forces: Mapping[Contact, np.ndarray]

    def clear(self) -> None:
        """Remove every constraint."""
        self.A.fill(0.0)
        self.lower.fill(-np.inf)
        self.upper.fill(np.inf)
        for F in self.forces.values():
            F.fill(0.0)


class Limit(ABC):
    """An inequality `lower ≤ A v̇ + Σ F_c f_c ≤ upper`, exact or of some priority.

    With priority 0 it holds exactly. With priority k it may be violated by w, at the cost
    `½ weight Σ w²` on the level of the tasks of that priority (see `wbc.Task`): it holds as far as
    exact rows and higher levels let it, and lower levels do not count against it.

    A limit of your own derives from this and writes its rows in `write`, anew each tick. Limits
    on single joints derive from `AccelerationBound` instead, which costs no rows.

    Args:
        name: unique within a controller; explanations quote it.
        size: number of rows m, fixed. A limit whose number of constraints varies, such as a
            collision barrier, takes the largest and leaves the other rows as they are.
        unit: unit of the rows' values; explanations quote it.
        labels: one text per row, for explanations.
        priority: 0 exact; 1, 2, … the level that pays for a violation.
        weight: of a violation among the costs of its level, above 0.

    Raises:
        LimitError: the size is not positive, the labels are not as many as the rows, or the
            priority or weight is out of range.
    """

    def __init__(
        self,
        name: str,
        size: int,
        *,
        unit: str,
        labels: Sequence[str] = (),
        priority: int = 0,
        weight: float = 1.0,
    ) -> None:
        if size < 1:
            raise LimitError(f"limit '{name}': size {size} must be at least one row")
        if labels and len(labels) != size:
            raise LimitError(f"limit '{name}': {len(labels)} labels for {size} rows")
        if isinstance(priority, bool) or not isinstance(priority, int) or priority < 0:
            raise LimitError(
                f"limit '{name}': priority {priority!r} must be a whole number: 0 (exact) or the "
                "level that pays for a violation, 1 for the highest"
            )
        if not 0.0 < weight < math.inf:
            raise LimitError(f"limit '{name}': weight {weight!r} must be positive and finite")
        self.name = name
        self.priority = priority
        self.weight = float(weight)
        self.size = size
        self.unit = unit
        self.labels = tuple(labels)

    def __repr__(self) -> str:
        rows = f"{self.size} row" + "s" * (self.size > 1)
        level = f", priority {self.priority}" if self.priority else ""
        return f"{type(self).__name__}('{self.name}', {rows}, {self.unit}{level})"

    def bind(self, robot: RobotModel) -> None:  # noqa: B027 - most limits need nothing here
        """Look up names in the robot, once, when given to a controller.

        Raises:
            FrameNotFound: the limit's frame is missing.
            JointNotFound: one of the limit's joints is missing.
        """

    @abstractmethod
    def write(self, kin: Kinematics, rows: LimitRows) -> None:
        """Write the rows of this tick.

        Args:
            kin: kinematics of the present state.
            rows: rows to write to.
        """

    def write_velocity(self, kin: Kinematics, dt: float, rows: LimitRows) -> None:
        """Write the rows at velocity level, `lower ≤ A v ≤ upper`.

        Args:
            kin: kinematics of a state at rest.
            dt: duration of the step, s.
            rows: rows to write to; `forces` is empty.

        Raises:
            LimitError: the limit has no form for velocities.
        """
        raise LimitError(
            f"limit '{self.name}' has no form for velocities: {type(self).__name__} lacks the "
            "method write_velocity"
        )
