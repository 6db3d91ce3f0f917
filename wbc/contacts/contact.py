"""The base of all contacts: a frame held by the environment, and a cone of contact forces."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
import pinocchio as pin

from wbc.errors import ContactError
from wbc.kinematics import Kinematics
from wbc.robot import Robot


class Contact(ABC):
    """A frame in contact with the environment.

    The frame's acceleration follows `J v̇ + J̇ v = −damping · velocity` in contact
    axes: exactly, or in the cost when `motion_weight` is given. The force obeys
    `cone @ f ≤ 0` and `min_force ≤ f_z ≤ max_force`.

    Args:
        frame: name of the frame.
        placement: `T_frame_contact`, the contact's axes in those of the frame; their z axis is
            the contact normal, out of the surface towards the robot. None: those of the frame.
        friction: Coulomb coefficient μ; the cone is approximated from inside by
            a pyramid of coefficient μ/√2.
        motion_weight: None for exact, else the weight (> 0) of the motion rows.
        damping: rate at which a residual velocity of the frame decays, 1/s.
        min_force: least normal force, N.
        max_force: largest normal force, N.
        name: unique within a controller; the frame's name when left out.

    All of these may be changed from tick to tick, but for frame and name; a placement only when
    one was given at first.

    A contact of your own derives from this (or from a contact of the library) and returns the
    rows of its cone, any number of them, from `make_cone`, and one text for each from
    `cone_labels`.

    Raises:
        ContactError: a value that makes no sense.
    """

    motion_size: ClassVar[int]  #: rows of the motion constraint, and unknowns of the force

    def __init__(
        self,
        frame: str,
        *,
        placement: pin.SE3 | None = None,
        friction: float = 0.7,
        motion_weight: float | None = None,
        damping: float = 30.0,
        min_force: float = 0.0,
        max_force: float = math.inf,
        name: str = "",
    ) -> None:
        self.frame = frame
        self.name = name or frame
        self.friction = friction
        if motion_weight is not None and not 0.0 < motion_weight < math.inf:
            raise ContactError(
                f"contact '{self.name}': motion_weight {motion_weight} must be positive "
                "and finite, or None for exact"
            )
        if not 0.0 <= damping < math.inf:
            raise ContactError(
                f"contact '{self.name}': damping {damping} must be finite and not negative"
            )
        if not 0.0 <= min_force <= max_force:
            raise ContactError(
                f"contact '{self.name}': need 0 ≤ min_force ({min_force}) ≤ max_force ({max_force})"
            )
        if placement is not None and not isinstance(placement, pin.SE3):
            raise ContactError(
                f"contact '{self.name}': placement is a {type(placement).__name__}, not a pin.SE3"
            )
        self.placement = placement
        self.motion_weight = motion_weight
        self.damping = damping
        self.min_force = min_force
        self.max_force = max_force
        self._robot: Robot | None = None
        self._frame_id = -1

    def __repr__(self) -> str:
        motion = "exact" if self.motion_weight is None else f"weight {self.motion_weight:g}"
        force = f", {self.min_force:g} to {self.max_force:g} N"
        if self.min_force == 0.0 and self.max_force == math.inf:
            force = ""
        return f"{type(self).__name__}('{self.name}', friction {self.friction:g}, {motion}{force})"

    @property
    def friction(self) -> float:
        """Coulomb coefficient μ."""
        return self._friction

    @friction.setter
    def friction(self, value: float) -> None:
        if not 0.0 < value < math.inf:
            raise ContactError(
                f"contact '{self.name}': friction {value} must be positive and finite"
            )
        self._friction = value
        self._cone: np.ndarray | None = None

    @property
    def cone(self) -> np.ndarray:
        """Rows of the force cone `cone @ f ≤ 0`, (k, motion_size), contact axes."""
        if self._cone is None:
            self._cone = self.make_cone(self._friction / math.sqrt(2.0))
        return self._cone

    @property
    def frame_id(self) -> int:
        """Index of the frame in the model, once bound; −1 before."""
        return self._frame_id

    @abstractmethod
    def make_cone(self, mu: float) -> np.ndarray:
        """Return the rows of `cone`, (k, motion_size).

        Their number must not change. Rows may be combinations of force components in N and
        moments in N·m, contact axes.

        Args:
            mu: coefficient of the pyramid, μ/√2.
        """

    @property
    @abstractmethod
    def cone_labels(self) -> tuple[str, ...]:
        """One text per row of `cone`."""

    def bind(self, robot: Robot) -> None:
        """Look up the frame, once.

        Raises:
            FrameNotFound: the frame is missing.
            ContactError: `motion_size`, `cone` or `cone_labels` of a contact of your own do not
                fit together.
        """
        if self._robot is not robot:
            self._check_cone()
            self._frame_id = robot.frame_id(self.frame)
            self._robot = robot

    def _check_cone(self) -> None:
        if not 3 <= self.motion_size <= 6:
            raise ContactError(
                f"contact '{self.name}': motion_size {self.motion_size} must be from 3 (a force) "
                "to 6 (a wrench)"
            )
        cone, labels = np.asarray(self.cone), self.cone_labels
        if cone.ndim != 2 or cone.shape[1] != self.motion_size or not np.isfinite(cone).all():
            raise ContactError(
                f"contact '{self.name}': make_cone returned an array of shape {cone.shape}; it "
                f"must be finite, of shape (rows, {self.motion_size})"
            )
        if len(labels) != cone.shape[0]:
            raise ContactError(
                f"contact '{self.name}': {len(labels)} cone_labels for {cone.shape[0]} rows"
            )

    def write(self, kin: Kinematics, J: np.ndarray, a: np.ndarray) -> None:
        """Write `J` (motion_size, nv) and `a` (motion_size,) of `J v̇ = a`, contact axes.

        `a` is in m/s² (and rad/s²).
        """
        n = self.motion_size
        jacobian, velocity, bias = self.motion(kin)
        J[:] = jacobian[:n]
        np.multiply(velocity[:n], -self.damping, out=a)
        a -= bias[:n]

    def motion(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return `J` (6, nv), `J v` and `J̇ v` (6,) of the contact's point, in contact axes."""
        at = kin.motion_local(self._frame_id)
        if self.placement is None:
            return at.jacobian, at.velocity, at.bias
        X = self.placement.toActionMatrixInverse()
        # The classical acceleration of another point adds ω × (ω × p).
        w, p = at.velocity[3:], self.placement.translation
        bias = X @ at.bias
        bias[:3] += self.placement.rotation.T @ (w * w.dot(p) - p * w.dot(w))
        return X @ at.jacobian, X @ at.velocity, bias

    def wrench(self, force: np.ndarray) -> np.ndarray:
        """Return the wrench (6,) at the contact's point, contact axes, in N and N·m.

        Args:
            force: the unknowns of the quadratic program, (motion_size,).
        """
        return np.concatenate((force, np.zeros(6 - force.size))) if force.size < 6 else force
