"""Surface contact: a flat rectangle on a surface."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.contacts.contact import Contact
from wbc.errors import ContactError
from wbc.robot import Sole


class SurfaceContact(Contact):
    """A rectangle that stays flat on the ground and transmits a wrench.

    The wrench (force, moment at the rectangle's centre, contact axes) satisfies the
    exact condition for non-slipping of the rectangle under friction pyramids at its
    four corners (Caron, Pham and Nakamura, Stability of surface contacts for humanoid
    robots, ICRA 2015): with X, Y half length and half width and μ the pyramid's
    coefficient,

        |f_x| ≤ μ f_z,  |f_y| ≤ μ f_z,  |τ_x| ≤ Y f_z,  |τ_y| ≤ X f_z,
        τ_z ≥ −μ (X + Y) f_z + |Y f_x − μ τ_x| + |X f_y − μ τ_y|,
        τ_z ≤ +μ (X + Y) f_z − |Y f_x + μ τ_x| − |X f_y + μ τ_y|.

    Args:
        frame: name of a frame; without a `placement` it is at the rectangle's centre, z the normal.
        half_length: X, along the contact's x axis, m.
        half_width: Y, along the contact's y axis, m.

    For the other arguments see `Contact`.

    Raises:
        ContactError: a value that makes no sense.
    """

    motion_size = 6

    def __init__(
        self,
        frame: str,
        half_length: float,
        half_width: float,
        *,
        placement: pin.SE3 | None = None,
        friction: float = 0.7,
        motion_weight: float | None = None,
        damping: float = 30.0,
        min_force: float = 0.0,
        max_force: float = float("inf"),
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
        if not (half_length > 0.0 and half_width > 0.0):
            raise ContactError(
                f"contact '{self.name}': half_length {half_length} and half_width {half_width} "
                "must be positive (use PointContact for a point)"
            )
        self.half_length = half_length
        self.half_width = half_width

    @classmethod
    def from_sole(cls, sole: Sole, *, margin: float = 0.0, friction: float = 0.7) -> SurfaceContact:
        """Return the contact of a robot's sole, its rectangle shrunk by `margin` (m) all around.

        Raises:
            ContactError: nothing is left of the rectangle.
        """
        return cls(
            sole.name, sole.half_length - margin, sole.half_width - margin, friction=friction
        )

    def make_cone(self, mu: float) -> np.ndarray:
        return wrench_cone(self.half_length, self.half_width, mu)

    @property
    def cone_labels(self) -> tuple[str, ...]:
        """See `Contact`."""
        return CONE_LABELS


CONE_LABELS = (
    *("friction +x", "friction -x", "friction +y", "friction -y"),
    *("cop right edge", "cop left edge", "cop front edge", "cop rear edge"),
    *(f"yaw torque {side}{k}" for side in "-+" for k in range(1, 5)),
)


def wrench_cone(X: float, Y: float, mu: float) -> np.ndarray:
    """Return the rows (16, 6) of `cone @ wrench ≤ 0` for a rectangle, see `SurfaceContact`.

    Args:
        X: half length, m.
        Y: half width, m.
        mu: coefficient of the friction pyramid.
    """
    rows = [
        [1, 0, -mu, 0, 0, 0],
        [-1, 0, -mu, 0, 0, 0],
        [0, 1, -mu, 0, 0, 0],
        [0, -1, -mu, 0, 0, 0],
        [0, 0, -Y, -1, 0, 0],
        [0, 0, -Y, 1, 0, 0],
        [0, 0, -X, 0, -1, 0],
        [0, 0, -X, 0, 1, 0],
    ]
    for sign in (-1, 1):  # lower, then upper bound of the yaw torque
        for a in (-1, 1):
            for b in (-1, 1):
                # sign·τ_z ≤ μ(X+Y) f_z − a (Y f_x + sign·μ τ_x) − b (X f_y + sign·μ τ_y)
                rows.append([a * Y, b * X, -mu * (X + Y), sign * a * mu, sign * b * mu, sign])
    return np.array(rows, dtype=float)
