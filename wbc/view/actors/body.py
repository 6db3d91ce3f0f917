"""The robot: one node per joint, under it the bodies that the joint carries."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.view.actors.actor import Actor, Moment, Node
from wbc.view.objects import Json


class Body(Actor):
    """The robot's bodies, moved joint by joint.

    Args:
        model: the robot's model.
        shapes: bodies per joint index, each placed in its joint's axes.
    """

    def __init__(self, model: pin.Model, shapes: dict[int, list[Json]]) -> None:
        self._joints = sorted(shapes)
        self.nodes = [
            Node(f"robot/{_safe(model.names[j])}", tuple(shapes[j]), smooth=True)
            for j in self._joints
        ]

    def place(self, moment: Moment, poses: np.ndarray) -> None:
        placements = moment.data.oMi
        for row, joint in zip(poses, self._joints, strict=True):
            row[0:7] = pin.SE3ToXYZQUAT(placements[joint])
        poses[:, 7:10] = 1.0


def _safe(name: str) -> str:
    return name.replace("/", "_")
