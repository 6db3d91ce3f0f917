"""Vertex normals that render curved surfaces smooth and edges sharp."""

from __future__ import annotations

import numpy as np

CREASE = np.deg2rad(35.0)
# Vertices with more faces than this are the tips of fans, for which flat shading suffices.
_CROWDED = 48


def creased(
    vertices: np.ndarray, faces: np.ndarray, crease: float = CREASE
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Split vertices where faces meet at more than the crease angle.

    A corner's normal is the area-weighted mean of the normals of those faces
    around its vertex that make less than the crease angle with its own face.

    Args:
        vertices: (n, 3) positions, m; each shared by the faces around it.
        faces: (m, 3) vertex indices.
        crease: Crease angle, rad.

    Returns:
        (k, 3) positions, (j, 3) indices and (k, 3) unit normals, faces of no
        area left out.
    """
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1)
    solid = lengths > 1e-14
    faces, areas, lengths = faces[solid], areas[solid], lengths[solid]
    units = areas / lengths[:, None]

    vertex = faces.ravel()
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.argsort(vertex, kind="stable")
    count = np.bincount(vertex, minlength=len(vertices))
    first = np.cumsum(count) - count
    around = np.where(count[vertex] <= _CROWDED, count[vertex], 0)

    # Every pair (corner, face around the corner's vertex), flattened.
    corner = np.repeat(np.arange(len(vertex)), around)
    step = np.arange(len(corner)) - np.repeat(np.cumsum(around) - around, around)
    other = face[order[first[vertex[corner]] + step]]
    near = np.einsum("ij,ij->i", units[face[corner]], units[other]) > np.cos(crease)
    corner, other = corner[near], other[near]
    normals: np.ndarray = np.stack(
        [np.bincount(corner, weights=areas[other, k], minlength=len(vertex)) for k in range(3)], 1
    )
    length = np.linalg.norm(normals, axis=1)
    lost = length < 1e-14
    normals[lost], length[lost] = units[face[lost]], 1.0
    normals /= length[:, None]

    # Corners of one vertex with one normal (to a tenth of a degree) become one vertex again.
    key = vertex.astype(np.int64)
    for k in range(3):
        key = (key << 10) | np.rint(normals[:, k] * 500 + 512).astype(np.int64)
    _, keep, index = np.unique(key, return_index=True, return_inverse=True)
    return vertices[vertex[keep]], index.reshape(-1, 3), normals[keep]
