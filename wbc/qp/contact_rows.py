"""The stacked motion rows of all contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.qp.row_errors import write_rows


class ContactRows:
    """`J v̇ = a` of all contacts, stacked, in contact axes; iterates over (contact, its rows).

    Attributes:
        J: (nf, nv).
        a: (nf,).
    """

    def __init__(self, contacts: Sequence[Contact], nv: int) -> None:
        size = sum(c.motion_size for c in contacts)
        self.J = np.zeros((size, nv))
        self.a = np.zeros(size)
        self._parts = []
        start = 0
        for contact in contacts:
            rows = slice(start, start + contact.motion_size)
            self._parts.append((contact, rows, self.J[rows], self.a[rows]))
            start = rows.stop

    def __iter__(self) -> Iterator[tuple[Contact, slice]]:
        return ((contact, rows) for contact, rows, _, _ in self._parts)

    def write(self, kin: Kinematics) -> None:
        """Compute J and a of the present state."""
        for contact, _, J, a in self._parts:
            write_rows(contact, kin, J, a)
