"""Orientation of the trunk along a heading."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import argument_types, kernel

_ROTATIONS = np.zeros((1, 3, 3))


@kernel(argument_types(1.0, _ROTATIONS, _ROTATIONS))
def turn_about_z(yaw: float, rotations: np.ndarray, out: np.ndarray) -> None:
    """Write rotations (n, 3, 3), turned about the world's z axis by yaw (rad), to `out`."""
    c, s = math.cos(yaw), math.sin(yaw)
    for k in range(rotations.shape[0]):
        for j in range(3):
            x, y = rotations[k, 0, j], rotations[k, 1, j]
            out[k, 0, j] = c * x - s * y
            out[k, 1, j] = s * x + c * y
            out[k, 2, j] = rotations[k, 2, j]
