"""The past path of the centre of mass."""

from __future__ import annotations

import numpy as np

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, hide, stretch
from wbc.view.colours import COM, faded
from wbc.view.objects import cylinder, flat, mesh

_PIECES = 120
_STEP = 0.04  # m, length of a segment on a robot of human size


class TrailActor(Actor):
    """A chain of thin rods, in which the oldest is reused as the newest."""

    def __init__(self, proportions: Proportions) -> None:
        self._step = _STEP * proportions.unit
        radius = 0.004 * proportions.unit
        material = flat(faded(COM, 0.45))
        self.nodes = []
        for i in range(_PIECES):
            rod = mesh(cylinder(radius, 1.0, segments=6), material)
            self.nodes.append(SceneNode(f"trail/{i}", (rod,)))
        self.restart()

    def restart(self) -> None:
        self._last: np.ndarray | None = None
        self._next = 0

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        if self._last is None:
            hide(poses)
            self._last = scene_input.com.copy()
        stretch(poses[self._next], self._last, scene_input.com)
        if np.linalg.norm(scene_input.com - self._last) >= self._step:
            self._last = scene_input.com.copy()
            self._next = (self._next + 1) % _PIECES
            hide(poses[self._next])
