"""Uneven ground: boxes, drawn as one mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wbc.view.errors import ViewerError

if TYPE_CHECKING:
    from trimesh import Trimesh


def checked_boxes(boxes: np.ndarray | None) -> np.ndarray:
    """Return centre and half sizes (m), roll and pitch (rad) of boxes, (n, 8); n = 0 for None.

    Raises:
        ViewerError: The array has another shape, or holds numbers that are not finite.
    """
    if boxes is None:
        return np.empty((0, 8))
    array = np.asarray(boxes, dtype=float)
    if array.ndim != 2 or array.shape[1] not in (6, 8) or not np.isfinite(array).all():
        raise ViewerError(
            f"boxes has shape {array.shape}; terrain is (n, 6) finite numbers: "
            "centre x y z, then half sizes, m; or (n, 8), then roll and pitch, rad"
        )
    if array.shape[1] == 6:
        array = np.column_stack((array, np.zeros((len(array), 2))))
    return array


def box_mesh(boxes: np.ndarray) -> Trimesh:
    """Return one mesh of all boxes."""
    # Imported here because `checked_boxes` runs in the loop's process.
    from trimesh import Trimesh, creation

    unit = creation.box((2.0, 2.0, 2.0))
    corners = unit.vertices * boxes[:, None, 3:6]
    (c, d), (s, t) = np.cos(boxes[:, 6:].T), np.sin(boxes[:, 6:].T)
    zero, one = np.zeros_like(c), np.ones_like(c)
    roll = np.array([[one, zero, zero], [zero, c, -s], [zero, s, c]])
    pitch = np.array([[d, zero, t], [zero, one, zero], [-t, zero, d]])
    turned = np.einsum("ijn,jkn,nvk->nvi", roll, pitch, corners)
    vertices = boxes[:, None, :3] + turned
    first = len(unit.vertices) * np.arange(len(boxes))[:, None, None]
    return Trimesh(vertices.reshape(-1, 3), (unit.faces + first).reshape(-1, 3), process=False)
