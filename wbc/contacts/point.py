"""Point contact."""

from __future__ import annotations

import numpy as np

from wbc.contacts.contact import Contact


class PointContact(Contact):
    """A point that does not slip and transmits a force but no moment.

    `|f_x| ≤ μ f_z` and `|f_y| ≤ μ f_z` with the pyramid's coefficient; see `Contact`
    for the arguments.
    """

    motion_size = 3

    def make_cone(self, mu: float) -> np.ndarray:
        return np.array([[1, 0, -mu], [-1, 0, -mu], [0, 1, -mu], [0, -1, -mu]], dtype=float)

    @property
    def cone_labels(self) -> tuple[str, ...]:
        """See `Contact`."""
        return ("friction +x", "friction -x", "friction +y", "friction -y")
