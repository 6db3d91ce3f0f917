"""A status light above the robot that shows the status of the tick's QP."""

from __future__ import annotations

import numpy as np

from wbc.command import Status
from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode, hide, set_position
from wbc.view.colours import STATUS
from wbc.view.objects import drawable, flat, sphere


class StatusLightActor(Actor):
    """One sphere per status, of which one is visible."""

    def __init__(self, proportions: Proportions) -> None:
        self._height = proportions.top - proportions.com_height + 0.14 * proportions.unit
        ball = sphere(0.03 * proportions.unit)
        self.nodes = [
            SceneNode(f"status_light/{status.value}", (drawable(ball, flat(STATUS[status])),))
            for status in Status
        ]

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        position = np.append(scene_input.base[:2], scene_input.com[2] + self._height)
        set_position(poses[list(Status).index(scene_input.snapshot.status)], position)
