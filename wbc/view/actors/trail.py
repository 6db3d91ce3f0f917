"""The past path of the centre of mass."""

from __future__ import annotations

import numpy as np
from trimesh.creation import cylinder

from wbc.view.actors.actor import Actor, Proportions, SceneInput, copies, hide, stretch
from wbc.view.colours import COM, faded
from wbc.view.objects import drawable, flat

_RODS = 120
_STEP = 0.04  # m, length of a segment on a robot of human size


class TrailActor(Actor):
    """A chain of thin rods, in which the oldest is reused as the newest."""

    def __init__(self, proportions: Proportions) -> None:
        self._step = _STEP * proportions.unit
        rod = cylinder(0.004 * proportions.unit, 1.0, sections=6)
        self.nodes = copies("trail/", _RODS, drawable(rod, flat(faded(COM, 0.45))))
        self.restart()

    def restart(self) -> None:
        self._last: np.ndarray | None = None
        self._next = 0

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        if self._last is None:
            hide(poses)
            self._last = scene_input.com.copy()
        stretch(poses[self._next], self._last, scene_input.com)
        if np.linalg.norm(scene_input.com - self._last) >= self._step:
            self._last = scene_input.com.copy()
            self._next = (self._next + 1) % _RODS
            hide(poses[self._next])
