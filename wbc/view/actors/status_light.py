"""A status light above the robot that shows the status of the tick's QP."""

from __future__ import annotations

import numpy as np

from wbc.command import Status
from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, hide, put
from wbc.view.colours import STATUS
from wbc.view.objects import flat, mesh, sphere


class StatusLightActor(Actor):
    """One sphere per status, of which one is visible."""

    def __init__(self, proportions: Proportions) -> None:
        self._height = proportions.top - proportions.com_height + 0.14 * proportions.unit
        self.nodes = []
        for status in Status:
            ball = mesh(sphere(0.03 * proportions.unit), flat(STATUS[status]))
            self.nodes.append(SceneNode(f"status_light/{status.value}", (ball,)))

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        position = np.array(
            [scene_input.base[0], scene_input.base[1], scene_input.com[2] + self._height]
        )
        put(poses[list(Status).index(scene_input.snapshot.status)], position)
