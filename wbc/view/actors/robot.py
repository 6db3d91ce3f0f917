"""The robot: one node per joint, with the shapes of the links that the joint moves."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.view.actors.actor import Actor, SceneInput, SceneNode
from wbc.view.objects import Json


class RobotActor(Actor):
    """The shapes of the robot, moved with the joints.

    Args:
        model: Pinocchio model of the robot.
        shapes: Maps each joint index to its shapes, placed in joint axes.
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
