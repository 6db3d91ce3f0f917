"""The support polygon: its edges and a translucent area."""

from __future__ import annotations

import numpy as np
from trimesh import Trimesh
from trimesh.creation import cylinder

from wbc.runtime.record import SUPPORT as CORNERS
from wbc.view.actors.actor import (
    Actor,
    Proportions,
    SceneInput,
    copies,
    hide,
    set_position,
    stretch,
)
from wbc.view.colours import SUPPORT, faded
from wbc.view.objects import drawable, flat, see_through

_LIFT = np.array([0.0, 0.0, 0.003])
_RADIUS = 0.004  # m, on a robot of human size
_TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


class SupportActor(Actor):
    """The edges are scaled cylinders, the area consists of scaled right-angled triangles."""

    def __init__(self, proportions: Proportions) -> None:
        rod = cylinder(_RADIUS * proportions.unit, 1.0, sections=6)
        edge = drawable(rod, see_through(SUPPORT), order=4)
        fill = drawable(Trimesh(_TRIANGLE, [[0, 1, 2]]), flat(faded(SUPPORT, 0.22)), order=2)
        self.nodes = copies("support/edge_", CORNERS, edge)
        self.nodes += copies("support/fill_", 2 * (CORNERS - 2), fill)

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        corners = scene_input.snapshot.contact_plan.support
        if len(corners) < 3 or not np.isfinite(corners).all():
            return
        corners = corners + _LIFT
        for i in range(len(corners)):
            stretch(poses[i], corners[i - 1], corners[i])
        fills = poses[CORNERS:]
        for i in range(1, len(corners) - 1):
            cover_triangle(fills[2 * i - 2 : 2 * i], corners[0], corners[i], corners[i + 1])


def cover_triangle(poses: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    """Cover a horizontal triangle by two right-angled ones: the poses of two unit triangles.

    A pose cannot shear, but the altitude on the longest side divides any triangle into two
    right-angled ones, which are scaled unit triangles.

    Args:
        poses: Poses to write, shape (2, 10).
        a: First corner, m, shape (3,); likewise `b` and `c`.
    """
    points = np.stack([a, b, c])
    sides = np.linalg.norm(np.roll(points, -1, 0) - np.roll(points, -2, 0), axis=1)
    k = int(np.argmax(sides))  # the corner opposite the longest side
    if sides[k] < 1e-9:
        return
    top, left, right = points[k], points[k - 2], points[k - 1]
    along = (right - left) / sides[k]
    foot = left + along * float(along @ (top - left))
    for pose, end in zip(poses, (left, right), strict=True):
        x, y = end - foot, top - foot
        if x[0] * y[1] - x[1] * y[0] < 0.0:
            x, y = y, x
        yaw = float(np.arctan2(x[1], x[0]))
        set_position(pose, foot, yaw)
        pose[7:10] = (np.hypot(x[0], x[1]), np.hypot(y[0], y[1]), 1.0)
