"""The floor and the boxes of a terrain in the physics."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.sim.terrain import HasFriction, Terrain

#: Up to this many boxes are all in the physics at once; of more, those near the robot.
_MAX_BOXES = 150
#: Boxes are present at least this far around the base, m: a long step and a fall.
_RADIUS = 1.5
#: How far the base may move before the boxes are placed anew, m.
_MAX_MOVE = 0.25
#: Height of boxes that are not needed, m.
_PARKED = -50.0


class Ground:
    """Places a terrain where the robot starts, and keeps the part near the robot in the physics.

    Thousands of boxes cost more than the robot's own dynamics even where nothing touches them.
    A large terrain of boxes of one size is therefore a window of bodies about the robot
    that follows it; a small one, or one of various boxes, is a single body.

    Args:
        terrain: its boxes, relative to the robot's start.
    """

    def __init__(self, terrain: Terrain) -> None:
        boxes = np.asarray(terrain.boxes(), dtype=float)
        self._boxes, self._turns = boxes[:, :6], boxes[:, 6:]
        self._friction = terrain.friction if isinstance(terrain, HasFriction) else None
        self._window = 0
        upright = not self._turns.any()
        if (
            upright
            and len(self._boxes) > _MAX_BOXES
            and not np.ptp(self._boxes[:, 3:], axis=0).any()
        ):
            sides = 2.0 * self._boxes[0, 3:5]
            across = np.ceil(2.0 * (_RADIUS + _MAX_MOVE) / sides) + 1.0
            self._window = min(len(self._boxes), int(across[0] * across[1]))

    def add_to(self, mujoco: Any, spec: Any, surface: dict[str, Any]) -> None:
        """Add floor and boxes to a `mujoco.MjSpec`; `surface` holds geom attributes."""
        world, box = spec.worldbody, mujoco.mjtGeom.mjGEOM_BOX
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        world.add_geom(name="floor", type=plane, size=[0.0, 0.0, 1.0], **surface)
        if self._friction is not None:
            # Of two surfaces that touch, that of the higher priority gives the friction.
            surface = surface | {"friction": [self._friction, 0.0, 0.0], "priority": 1}
        if self._window:
            size = self._boxes[0, 3:]
            for i in range(self._window):
                body = world.add_body(name=f"terrain_{i}", mocap=True)
                body.add_geom(type=box, size=size, **surface)
        elif len(self._boxes):
            # A mocap body can be placed where the robot starts without compiling anew.
            patch = world.add_body(name="terrain", mocap=True)
            turns = self._turns if self._turns.size else np.zeros((len(self._boxes), 2))
            for b, (roll, pitch) in zip(self._boxes, turns, strict=True):
                quat = _rolled_and_pitched(0.5 * roll, 0.5 * pitch)
                patch.add_geom(type=box, pos=b[:3], size=b[3:], quat=quat, **surface)

    def place(self, data: Any, x: float, y: float, yaw: float) -> None:
        """Place the terrain's origin at a position and heading in the world, m and rad."""
        if not len(self._boxes):
            return
        c, s = np.cos(yaw), np.sin(yaw)
        bodies = slice(self._window or 1)  # they are the first
        data.mocap_quat[bodies] = [np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)]
        data.mocap_pos[bodies] = [x, y, 0.0]
        if self._window:
            self._centres = self._boxes[:, :3].copy()
            self._centres[:, :2] = self._boxes[:, :2] @ np.array([[c, s], [-s, c]]) + [x, y]
            self._place_window(data, x, y)

    def follow(self, data: Any) -> None:
        """Move the window of boxes with the robot."""
        if not self._window:
            return
        x, y = data.qpos[:2].tolist()
        if max(abs(x - self._at[0]), abs(y - self._at[1])) > _MAX_MOVE:
            self._place_window(data, x, y)

    def _place_window(self, data: Any, x: float, y: float) -> None:
        self._at = (x, y)
        distance = np.hypot(*(self._centres[:, :2] - [x, y]).T)
        near = np.argpartition(distance, self._window - 1)[: self._window]
        data.mocap_pos[: self._window] = self._centres[near]
        far = distance[near] > 2.0 * _RADIUS + self._boxes[0, 3]
        data.mocap_pos[np.flatnonzero(far), 2] = _PARKED


def _rolled_and_pitched(half_roll: float, half_pitch: float) -> list[float]:
    """Return the quaternion (w, x, y, z) of a roll about x, then a pitch about the new y."""
    c, s = np.cos(half_roll), np.sin(half_roll)
    d, t = np.cos(half_pitch), np.sin(half_pitch)
    return [c * d, s * d, c * t, s * t]
