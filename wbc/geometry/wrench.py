"""Contact wrenches of plane contacts."""

from __future__ import annotations

import numpy as np


def centre_of_pressure(wrench: np.ndarray, min_force: float = 1.0) -> np.ndarray:
    """Return where a plane contact's force acts: the point without tangential moment.

        x = −m_y / f_z,   y = m_x / f_z

    Args:
        wrench: (6,) force then moment about the contact's origin, contact axes, N and N·m.
        min_force: normal force below which the contact's origin is returned, N.

    Returns:
        (3,) position on the contact plane, contact axes, m.
    """
    normal = float(wrench[2])
    if normal < min_force:
        return np.zeros(3)
    return np.array([-wrench[4] / normal, wrench[3] / normal, 0.0])
