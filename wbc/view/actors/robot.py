"""The robot: one node per joint, under it the bodies that the joint carries."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.view.actors.actor import Actor, SceneInput, SceneNode
from wbc.view.objects import Json


class RobotActor(Actor):
    """The robot's bodies, moved joint by joint.

    Args:
        model: the robot's model.
        shapes: bodies per joint index, each placed in its joint's axes.
    """

    def __init__(self, model: pin.Model, shapes: dict[int, list[Json]]) -> None:
        self._joints = sorted(shapes)
        self.nodes = [
            SceneNode(f"robot/{_safe(model.names[j])}", tuple(shapes[j]), smooth=True)
            for j in self._joints
        ]

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        placements = scene_input.data.oMi
        for row, joint in zip(poses, self._joints, strict=True):
            row[0:7] = pin.SE3ToXYZQUAT(placements[joint])
        poses[:, 7:10] = 1.0


def _safe(name: str) -> str:
    return name.replace("/", "_")
