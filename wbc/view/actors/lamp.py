"""A lamp above the robot that shows how the tick's QP ended."""

from __future__ import annotations

import numpy as np

from wbc.command import Status
from wbc.view.actors.actor import Actor, Moment, Node, Proportions, hide, put
from wbc.view.colours import STATUS
from wbc.view.objects import flat, mesh, sphere


class Lamp(Actor):
    """One ball per status, of which one is seen."""

    def __init__(self, proportions: Proportions) -> None:
        self._height = proportions.top - proportions.com_height + 0.14 * proportions.unit
        self.nodes = []
        for status in Status:
            ball = mesh(sphere(0.03 * proportions.unit), flat(STATUS[status]))
            self.nodes.append(Node(f"lamp/{status.value}", (ball,)))

    def place(self, moment: Moment, poses: np.ndarray) -> None:
        hide(poses)
        position = np.array([moment.base[0], moment.base[1], moment.com[2] + self._height])
        put(poses[list(Status).index(moment.snapshot.status)], position)
