"""The base of all tasks: weighted or exact linear rows in the acceleration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from wbc.errors import TaskError
from wbc.formatting import format_range
from wbc.kinematics import Kinematics
from wbc.robot import RobotModel


class Task(ABC):
    """A desired acceleration: rows `A v̇ = b`, exact or weighted on a level of strict priority.

    A task of priority 0 becomes equality rows, which hold exactly. One of priority k ≥ 1 adds
    `½ Σ wᵢ (Aᵢ v̇ − bᵢ)²` to the cost of level k. Tasks of one level are weighted against each
    other; a level is minimised among the optima of all higher ones, those of smaller numbers, and
    never makes one of them worse. The second-order form is
    `b = a_ref + kd (v_ref − v) + kp (x_ref ⊖ x) − J̇ v`.

    A task of your own derives from this and writes its rows in `write`.

    Args:
        name: unique within a controller; explanations quote it.
        size: number of rows m.
        weight: scalar or (m,), ≥ 0. A row of weight 0 is left out of the cost.
        kp: position gain, 1/s², scalar or (m,).
        kd: velocity gain, 1/s; critically damped (2 √kp) when left out.
        priority: 0 exact; 1, 2, … the level, 1 for the highest. Numbers may be left out.

    Attributes:
        labels: one text per row, for explanations; may be empty.
        gains: another object whenever weight, kp or kd were set.

    Raises:
        TaskError: a weight or gain is negative, not finite or of a wrong shape,
            or the priority is no whole number from 0 on.
    """

    unit: ClassVar[str]

    def __init__(
        self,
        name: str,
        size: int,
        weight: float | np.ndarray,
        kp: float | np.ndarray,
        kd: float | np.ndarray | None,
        priority: int,
    ) -> None:
        self.name = name
        self.size = size
        self.priority = priority
        self.check_priority()
        self.labels: tuple[str, ...] = ()
        self.weight = weight
        self.kp = kp
        self.kd = 2.0 * np.sqrt(self.kp) if kd is None else kd

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a copy; its gains are to be changed through their check only, as before."""
        self.__dict__.update(state)
        for gain in (self._weight, self._kp, self._kd):
            gain.setflags(write=False)

    def __repr__(self) -> str:
        role = "exact" if self.priority == 0 else f"weight {format_range(self.weight)}"
        role += f", priority {self.priority}" if self.priority > 1 else ""
        gains = f"kp {format_range(self.kp)} 1/s², kd {format_range(self.kd)} 1/s"
        target = self._format_target()
        texts = [f"'{self.name}'", role, gains, *([f"target {target}"] if target else [])]
        return f"{type(self).__name__}({', '.join(texts)})"

    def _format_target(self) -> str:
        """Return the target with its unit for `repr`; empty when there is none to show."""
        return ""

    @property
    def weight(self) -> np.ndarray:
        """(m,) weight per row; set a scalar or (m,)."""
        return self._weight

    @weight.setter
    def weight(self, value: float | np.ndarray) -> None:
        self._weight = self._gain("weight", value)
        self.sqrt_weight = np.sqrt(self._weight)
        self.gains = object()

    @property
    def kp(self) -> np.ndarray:
        """(m,) position gain per row, 1/s²; set a scalar or (m,)."""
        return self._kp

    @kp.setter
    def kp(self, value: float | np.ndarray) -> None:
        self._kp = self._gain("kp", value)
        self.gains = object()

    @property
    def kd(self) -> np.ndarray:
        """(m,) velocity gain per row, 1/s; set a scalar or (m,)."""
        return self._kd

    @kd.setter
    def kd(self, value: float | np.ndarray) -> None:
        self._kd = self._gain("kd", value)
        self.gains = object()

    def _gain(self, what: str, value: float | np.ndarray) -> np.ndarray:
        array = self._floats(what, value)
        if array.ndim == 0:
            array = np.full(self.size, float(array))
        if array.shape != (self.size,):
            raise TaskError(
                f"task '{self.name}': {what} has shape {array.shape}, "
                f"expected a number or ({self.size},)"
            )
        if not (array >= 0.0).all() or not np.isfinite(array).all():
            raise TaskError(f"task '{self.name}': {what} = {value} must be finite and not negative")
        array.setflags(write=False)  # a change must come through the check
        return array

    def _floats(self, what: str, value: object) -> np.ndarray:
        try:
            return np.array(value, dtype=float)
        except (TypeError, ValueError):
            raise TaskError(
                f"task '{self.name}': {what} = {value!r} is neither a number nor an array of them"
            ) from None

    def _vector(self, what: str, value: np.ndarray | tuple[float, ...], size: int) -> np.ndarray:
        array = self._floats(what, value)
        if array.shape != (size,):
            raise TaskError(
                f"task '{self.name}': {what} has shape {array.shape}, expected ({size},)"
            )
        bad = np.flatnonzero(~np.isfinite(array))
        if bad.size:
            first = int(bad[0])
            entry = f" ({self.labels[first]})" if first < len(self.labels) else ""
            raise TaskError(
                f"task '{self.name}': {what}[{first}]{entry} is {array[first]}, it must be finite"
            )
        return array

    def check_priority(self) -> None:
        """Check the priority, which may be set at any time.

        Raises:
            TaskError: it is no whole number from 0 on.
        """
        priority = self.priority
        if isinstance(priority, bool) or not isinstance(priority, int) or priority < 0:
            raise TaskError(
                f"task '{self.name}': priority {priority!r} must be a whole number: 0 (exact), or "
                "the level, 1 for the highest"
            )

    def bind(self, robot: RobotModel) -> None:  # noqa: B027 - most tasks need nothing here
        """Look up names in the robot, once, when added to a controller.

        Raises:
            FrameNotFound: the task's frame is missing.
            JointNotFound: one of the task's joints is missing.
            TaskError: the target does not fit the robot.
        """

    @abstractmethod
    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """Write the rows of this tick, unweighted.

        Args:
            kin: kinematics of the present state.
            A: (m, nv) to be written; the array of the last tick.
            b: (m,) to be written.
        """

    @property
    def velocity_gain(self) -> np.ndarray:
        """(m,) gain of the task at velocity level, 1/s: kp/kd, or kp where kd is zero."""
        return np.asarray(self.kp / np.where(self.kd > 0.0, self.kd, 1.0))

    def write_velocity(
        self, kin: Kinematics, J: np.ndarray, velocity: np.ndarray, error: np.ndarray
    ) -> None:
        """Write the rows at velocity level, unweighted: `J v = velocity + (kp/kd) error`.

        This is the velocity at which the second-order law asks for no more correction than its
        feed-forward. Unless overridden, the rows are those of `write` for a robot at rest, with
        `b / kp` for an error.

        Args:
            kin: kinematics of a state at rest.
            J: (m, nv) to be written; the array of the last call.
            velocity: (m,) to be written: reference velocity.
            error: (m,) to be written: target minus present value.

        Raises:
            TaskError: the task has no meaning for velocities.
        """
        self.write(kin, J, error)
        free = self.kp <= 0.0
        velocity[:] = np.where(free & (self.kd > 0.0), error / np.maximum(self.kd, 1e-300), 0.0)
        error[:] = np.where(free, 0.0, error / np.maximum(self.kp, 1e-300))


class JointTask(Task):
    """A task each of whose rows is about one joint's acceleration.

    Weighted ones need no dense rows: they only touch H's diagonal.

    Attributes:
        index: (m,) the joints, as indices into (na,) vectors.
    """

    index: np.ndarray

    @abstractmethod
    def write_joints(self, kin: Kinematics, b: np.ndarray) -> None:
        """Write `b` (m,), the desired joint accelerations, rad/s²."""

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """See `Task.write`."""
        A[:] = 0.0
        A[np.arange(self.size), 6 + self.index] = 1.0
        self.write_joints(kin, b)
