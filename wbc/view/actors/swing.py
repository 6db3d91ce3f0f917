"""The remaining path of the swing sole, as a row of small spheres."""

from __future__ import annotations

import numpy as np

from wbc.view.actors.actor import Actor, Proportions, SceneInput, copies, hide, set_position
from wbc.view.colours import SWING
from wbc.view.objects import drawable, flat, sphere

_DOTS = 24


class SwingActor(Actor):
    """Spheres at equal distances along the swing path."""

    def __init__(self, proportions: Proportions) -> None:
        dot = sphere(0.007 * proportions.unit, segments=8)
        self.nodes = copies("swing/", _DOTS, drawable(dot, flat(SWING)))

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        path = scene_input.snapshot.contact_plan.swing_path
        if len(path) < 2 or not np.isfinite(path).all():
            return
        lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(lengths)])
        if arc[-1] < 1e-4:
            return
        at = np.linspace(0.0, arc[-1], _DOTS)
        dots = np.stack([np.interp(at, arc, path[:, k]) for k in range(3)], axis=1)
        for pose, dot in zip(poses, dots, strict=True):
            set_position(pose, dot)
