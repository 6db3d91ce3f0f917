"""The scene: its objects, created once, and their poses at a snapshot.

All viewers draw with this class: the live viewer sends the poses that changed, and a recording
stores them as keyframe tracks.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.runtime.snapshot import Snapshot
from wbc.view.actors.actor import Actor, Proportions, SceneInput, SceneNode
from wbc.view.actors.balance import BalanceActor
from wbc.view.actors.floor import FloorActor
from wbc.view.actors.footsteps import FootstepsActor
from wbc.view.actors.forces import ForcesActor
from wbc.view.actors.robot import RobotActor
from wbc.view.actors.status_light import StatusLightActor
from wbc.view.actors.support import SupportActor
from wbc.view.actors.swing import SwingActor
from wbc.view.actors.trail import TrailActor
from wbc.view.colours import TERRAIN
from wbc.view.objects import drawable, matte, set_object
from wbc.view.terrain import box_mesh, checked_boxes
from wbc.view.visuals import RobotVisuals, visuals_of

if TYPE_CHECKING:
    from wbc.robot import Robot

ROOT = "/wbc"
_HIDDEN = np.array([0.0, 0, 0, 0, 0, 0, 1, 0, 0, 0])


class Scene:
    """The robot, its surroundings and the symbols that show its state.

    Args:
        robot: Robot to draw.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.
        visuals: Shapes of the robot; by default its meshes are read.

    Attributes:
        visuals: Shapes of the robot.
        nodes: Nodes of the scene tree, in the order of `poses`.
        poses: `[position, quaternion x y z w, scale]` of each node, shape (n, 10).
        proportions: Dimensions of the robot.
        source: Note on the shapes of a robot without visual shapes; otherwise empty.
    """

    def __init__(
        self,
        robot: Robot,
        boxes: np.ndarray | None = None,
        visuals: RobotVisuals | None = None,
    ) -> None:
        self._model = robot.model
        self._data = robot.model.createData()
        self._soles = {sole.name: int(sole.frame_id) for sole in robot.soles}
        self._frames = {frame.name: i for i, frame in enumerate(self._model.frames)} | self._soles
        self._boxes = checked_boxes(boxes)
        self.visuals = visuals = visuals or visuals_of(robot)
        self.source = visuals.source
        weight = robot.weight
        self.proportions = p = Proportions(robot.com_height, visuals.top, max(weight, 1e-3))
        self._actors: list[Actor] = [
            RobotActor(self._model, visuals.shapes),
            FloorActor(p),
            *(FootstepsActor(sole, p) for sole in robot.soles),
            SupportActor(p),
            ForcesActor(p),
            BalanceActor(p),
            TrailActor(p),
            SwingActor(p),
            StatusLightActor(p),
        ]
        self.nodes: list[SceneNode] = [node for actor in self._actors for node in actor.nodes]
        self.poses = np.tile(_HIDDEN, (len(self.nodes), 1))
        self._time: float | None = None
        self._run = 0

    @property
    def paths(self) -> list[str]:
        """The full path of each node."""
        return [n.path if n.path.startswith("/") else f"{ROOT}/{n.path}" for n in self.nodes]

    def commands(self) -> Iterator[bytes]:
        """Yield the commands that create all objects."""
        for path, node in zip(self.paths, self.nodes, strict=True):
            for i, description in enumerate(node.objects):
                yield set_object(f"{path}/{i}", description)
        if len(self._boxes):
            yield set_object(f"{ROOT}/terrain", drawable(box_mesh(self._boxes), matte(TERRAIN)))

    def update(self, snapshot: Snapshot) -> bool:
        """Update all poses to a snapshot.

        Returns:
            False if the configuration is not finite; the poses are then unchanged.
        """
        if not np.isfinite(snapshot.q).all():
            return False
        if self._time is None or snapshot.time < self._time or snapshot.run != self._run:
            for actor in self._actors:
                actor.restart()
            self._time, self._run = snapshot.time, snapshot.run
        scene_input = self._scene_input(snapshot, snapshot.time - self._time)
        self._time = snapshot.time
        start = 0
        for actor in self._actors:
            stop = start + len(actor.nodes)
            actor.set_poses(scene_input, self.poses[start:stop])
            start = stop
        # A non-finite number would invalidate the whole message, so its node is hidden instead.
        invalid = ~np.isfinite(self.poses).all(axis=1)
        self.poses[invalid] = _HIDDEN
        return True

    def _scene_input(self, snapshot: Snapshot, dt: float) -> SceneInput:
        pin.framesForwardKinematics(self._model, self._data, snapshot.q)
        com = snapshot.telemetry.com
        if not np.isfinite(com).all():
            com = pin.centerOfMass(self._model, self._data, False).copy()
        placements = self._data.oMf
        contacts = {
            name: (placements[self._frames[name]], wrench)
            for name, wrench in snapshot.wrenches.items()
            if np.isfinite(wrench).all() and name in self._frames
        }
        soles = {name: placements[frame] for name, frame in self._soles.items()}
        base = np.array(self._data.oMi[1].translation)
        return SceneInput(snapshot, self._data, contacts, soles, com, base, dt)
