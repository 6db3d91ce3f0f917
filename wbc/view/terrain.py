"""Uneven ground: upright boxes, drawn as one mesh."""

from __future__ import annotations

import numpy as np

from wbc.view.errors import ViewerError


def checked_boxes(boxes: np.ndarray | None) -> np.ndarray:
    """Return centre and half sizes of upright boxes, m, shape (n, 6); n = 0 for None.

    Raises:
        ViewerError: The array has another shape, or holds numbers that are not finite.
    """
    if boxes is None:
        return np.empty((0, 6))
    array = np.asarray(boxes, dtype=float)
    if array.ndim != 2 or array.shape[1] != 6 or not np.isfinite(array).all():
        raise ViewerError(
            f"boxes has shape {array.shape}; terrain is (n, 6) finite numbers: "
            "centre x y z, then half sizes, m"
        )
    return array


def box_mesh(boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a mesh of all boxes: (24 n, 3) vertices, (12 n, 3) faces and (24 n, 3) normals."""
    corners, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = side
            u, v = np.roll(np.eye(3), 1, axis=0)[[axis, axis - 1]]
            if np.cross(u, v) @ normal < 0:
                u, v = v, u
            corners += [normal + a * u + b * v for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            normals += [normal] * 4
    vertices = boxes[:, None, :3] + np.array(corners) * boxes[:, None, 3:]
    first = 4 * np.arange(6 * len(boxes))[:, None]
    faces = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    return vertices.reshape(-1, 3), faces, np.tile(np.array(normals), (len(boxes), 1))
