"""The base of all contacts: a frame that the ground holds, and the forces it may bear."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from wbc.errors import ContactError
from wbc.kinematics import Kinematics
from wbc.robot import Robot


class Contact(ABC):
    """A frame in contact with the environment.

    The frame's acceleration follows `J v̇ + J̇ v = −damping · velocity` in contact
    axes: exactly, or in the cost when `motion_weight` is given. The force obeys
    `cone @ f ≤ 0` and `min_force ≤ f_z ≤ max_force`.

    Args:
        frame: name of the frame; its z axis is the contact normal, away from the ground.
        friction: Coulomb coefficient μ; the cone is approximated from inside by
            a pyramid of coefficient μ/√2.
        motion_weight: None for exact, else the weight (> 0) of the motion rows.
        damping: how fast a residual velocity of the frame is brought to zero, 1/s.
        min_force: least normal force, N.
        max_force: largest normal force, N.

    Raises:
        ContactError: a value that makes no sense.
    """

    motion_size: ClassVar[int]  #: rows of the motion constraint, and unknowns of the force

    def __init__(
        self,
        frame: str,
        *,
        friction: float = 0.7,
        motion_weight: float | None = None,
        damping: float = 30.0,
        min_force: float = 0.0,
        max_force: float = float("inf"),
        name: str = "",
    ) -> None:
        self.name = name or frame
        if not friction > 0.0:
            raise ContactError(f"contact '{self.name}': friction {friction} must be positive")
        if motion_weight is not None and not motion_weight > 0.0:
            raise ContactError(
                f"contact '{self.name}': motion_weight {motion_weight} must be positive, or None for exact"
            )
        if not damping >= 0.0:
            raise ContactError(f"contact '{self.name}': damping {damping} must not be negative")
        if not 0.0 <= min_force <= max_force:
            raise ContactError(
                f"contact '{self.name}': need 0 ≤ min_force ({min_force}) ≤ max_force ({max_force})"
            )
        self.frame = frame
        self.friction = friction
        self.motion_weight = motion_weight
        self.damping = damping
        self.min_force = min_force
        self.max_force = max_force
        self._frame_id = -1

    @property
    @abstractmethod
    def cone(self) -> np.ndarray:
        """(k, motion_size) rows of the force cone `cone @ f ≤ 0`, contact axes."""

    @property
    @abstractmethod
    def cone_labels(self) -> tuple[str, ...]:
        """One text per row of `cone`."""

    def bind(self, robot: Robot) -> None:
        """Look up the frame, once.

        Raises:
            FrameNotFound: the frame is missing.
        """
        self._frame_id = robot.frame_id(self.frame)

    def motion(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """`(J, a)` of the motion constraint `J v̇ = a`, in contact axes.

        J is (motion_size, nv), a is (motion_size,), m/s² (and rad/s²).
        """
        at = kin.motion(self._frame_id)
        R = at.rotation
        n = self.motion_size
        J = np.empty((n, at.jacobian.shape[1]))
        acceleration = -self.damping * at.velocity - at.bias
        a = np.empty(n)
        J[:3] = R.T @ at.jacobian[:3]
        a[:3] = R.T @ acceleration[:3]
        if n == 6:
            J[3:] = R.T @ at.jacobian[3:]
            a[3:] = R.T @ acceleration[3:]
        return J, a
