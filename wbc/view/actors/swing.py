"""The remaining path of the swing sole, as a row of small spheres."""

from __future__ import annotations

import numpy as np

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, hide, put
from wbc.view.colours import SWING
from wbc.view.objects import flat, mesh, sphere

_BEADS = 24


class SwingActor(Actor):
    """Spheres at equal distances along the swing path."""

    def __init__(self, proportions: Proportions) -> None:
        self.nodes = []
        for i in range(_BEADS):
            bead = mesh(sphere(0.007 * proportions.unit, segments=8), flat(SWING))
            self.nodes.append(SceneNode(f"swing/{i}", (bead,)))

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        path = scene_input.snapshot.contact_plan.swing_path
        if len(path) < 2 or not np.isfinite(path).all():
            return
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        if way[-1] < 1e-4:
            return
        at = np.linspace(0.0, way[-1], _BEADS)
        beads = np.stack([np.interp(at, way, path[:, k]) for k in range(3)], axis=1)
        for row, bead in zip(poses, beads, strict=True):
            put(row, bead)
