"""Edge contact: a foot that tips over an edge of its sole."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from wbc.contacts.contact import Contact
from wbc.errors import ContactError
from wbc.kinematics import Kinematics
from wbc.robot import Sole

_CONE_LABELS = (
    *("friction +x", "friction -x", "friction +y", "friction -y"),
    *("cop front end", "cop rear end"),
    *("friction +y, front end", "friction -y, front end"),
    *("friction +y, rear end", "friction -y, rear end"),
)
_MOTION = [0, 1, 2, 4, 5]  # rows of the edge's motion: all but the turning about it


class EdgeContact(Contact):
    """A straight edge that does not slip, and about which the body is free to turn.

    The edge lies along the contact's x axis. It transmits a force and the moments about y and z,
    but none about itself: two points at its ends with friction pyramids, so that, with the half
    length X and the pyramid's coefficient μ,

        |f_x| ≤ μ f_z,  |f_y| ≤ μ f_z,  |τ_y| ≤ X f_z,
        |X f_y + τ_z| ≤ μ (X f_z − τ_y),  |X f_y − τ_z| ≤ μ (X f_z + τ_y),

    which is the wrench cone of a rectangle without a width (Caron, Pham and Nakamura, Stability of
    surface contacts for humanoid robots, ICRA 2015). `Command.wrenches` has its wrench at the
    frame's origin, in the frame's axes.

    Args:
        frame: name of the frame; without a `placement` it is at the edge's centre.
        half_length: X, m.

    For the other arguments see `Contact`.

    Raises:
        ContactError: a value that makes no sense.
    """

    motion_size = 5

    def __init__(
        self,
        frame: str,
        half_length: float,
        *,
        placement: pin.SE3 | None = None,
        friction: float = 0.7,
        motion_weight: float | None = None,
        damping: float = 30.0,
        min_force: float = 0.0,
        max_force: float = math.inf,
        name: str = "",
    ) -> None:
        super().__init__(
            frame,
            placement=placement,
            friction=friction,
            motion_weight=motion_weight,
            damping=damping,
            min_force=min_force,
            max_force=max_force,
            name=name,
        )
        if not half_length > 0.0:
            raise ContactError(
                f"contact '{self.name}': half_length {half_length} must be positive "
                "(use PointContact for a point)"
            )
        self.half_length = half_length

    @classmethod
    def of_sole(cls, sole: Sole, outward: complex, *, friction: float = 0.7) -> EdgeContact:
        """Return the contact of an edge of a sole.

        It is where the sole ends: nothing is left unused, because the edge is all that touches.

        Args:
            sole: the sole.
            outward: direction from its centre to the edge, x + iy in its axes: 1 the toe, −1 the
                heel, 1j the left and −1j the right edge.
            friction: see `Contact`.
        """
        along = outward * -1j
        rotation = np.array(
            [[along.real, -along.imag, 0.0], [along.imag, along.real, 0.0], [0.0, 0.0, 1.0]]
        )
        place = np.array([outward.real * sole.half_length, outward.imag * sole.half_width, 0.0])
        half_length = sole.half_length if outward.imag else sole.half_width
        return cls(sole.name, half_length, placement=pin.SE3(rotation, place), friction=friction)

    def make_cone(self, mu: float) -> np.ndarray:
        """See `Contact.make_cone`."""
        X = self.half_length
        rows = [[1, 0, -mu, 0, 0], [-1, 0, -mu, 0, 0], [0, 1, -mu, 0, 0], [0, -1, -mu, 0, 0]]
        rows += [[0, 0, -X, -1, 0], [0, 0, -X, 1, 0]]
        for end in (1, -1):  # friction of the point at that end
            for sign in (1, -1):
                rows.append([0, sign * X, -mu * X, end * mu, end * sign])
        return np.array(rows, dtype=float)

    @property
    def cone_labels(self) -> tuple[str, ...]:
        """See `Contact`."""
        return _CONE_LABELS

    def write(self, kin: Kinematics, J: np.ndarray, a: np.ndarray) -> None:
        """See `Contact.write`."""
        jacobian, velocity, bias = self.motion(kin)
        J[:] = jacobian[_MOTION]
        a[:] = -self.damping * velocity[_MOTION] - bias[_MOTION]

    def wrench(self, force: np.ndarray) -> np.ndarray:
        """Return the wrench (6,) at the frame's origin, in its axes, like that of a whole sole."""
        at_edge = pin.Force(force[:3], np.array([0.0, force[3], force[4]]))
        if self.placement is None:
            return np.array(at_edge.vector)
        return np.array(self.placement.act(at_edge).vector)
