"""Uneven ground: upright boxes, drawn as one mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wbc.view.errors import ViewerError

if TYPE_CHECKING:
    from trimesh import Trimesh


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


def box_mesh(boxes: np.ndarray) -> Trimesh:
    """Return one mesh of all boxes."""
    # Imported here because `checked_boxes` runs in the loop's process.
    from trimesh import Trimesh, creation

    unit = creation.box((2.0, 2.0, 2.0))
    vertices = boxes[:, None, :3] + unit.vertices * boxes[:, None, 3:]
    first = len(unit.vertices) * np.arange(len(boxes))[:, None, None]
    return Trimesh(vertices.reshape(-1, 3), (unit.faces + first).reshape(-1, 3), process=False)
