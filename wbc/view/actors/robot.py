"""The robot: one node per joint, with the shapes of the links that the joint moves."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from trimesh import Trimesh

from wbc.view.actors.actor import Actor, SceneInput, SceneNode, set_placement
from wbc.view.colours import Colour
from wbc.view.objects import drawable, matte


class RobotActor(Actor):
    """The shapes of the robot, moved with the joints.

    Args:
        model: Pinocchio model of the robot.
        shapes: Maps each joint index to its shapes, in joint axes, m, and their colours.
    """

    def __init__(self, model: pin.Model, shapes: dict[int, list[tuple[Trimesh, Colour]]]) -> None:
        self._joints = sorted(shapes)
        self.nodes = []
        for joint in self._joints:
            objects = tuple(drawable(shape, matte(colour)) for shape, colour in shapes[joint])
            name = model.names[joint].replace("/", "_")
            self.nodes.append(SceneNode(f"robot/{name}", objects, smooth=True))

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        for pose, joint in zip(poses, self._joints, strict=True):
            set_placement(pose, scene_input.data.oMi[joint])
