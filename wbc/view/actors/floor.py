"""The floor and the lights, which move with the robot, and the camera, which follows it."""

from __future__ import annotations

import numpy as np

from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, set_position

CAMERA = "/Cameras/default"
SURROUNDINGS = "surroundings"
_TAU = 0.5  # s, time constant of the camera
_TILE = 1.0  # m, period of the floor's pattern


class FloorActor(Actor):
    """Moves the floor, the lights and the camera's target, which the page creates."""

    def __init__(self, proportions: Proportions) -> None:
        self._height = 0.5 * proportions.top
        self.nodes = [SceneNode(SURROUNDINGS, ()), SceneNode(CAMERA, (), smooth=True)]
        self.restart()

    def restart(self) -> None:
        self._target: np.ndarray | None = None

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        aim = np.array([scene_input.base[0], scene_input.base[1], self._height])
        if self._target is None or np.linalg.norm(aim - self._target) > 5.0:
            self._target = aim
        self._target = self._target + (1.0 - np.exp(-scene_input.dt / _TAU)) * (aim - self._target)
        # The floor moves by whole tiles, so that it appears fixed.
        x, y = np.round(aim[:2] / _TILE) * _TILE
        set_position(poses[0], np.array([x, y, 0.0]))
        set_position(poses[1], self._target)
