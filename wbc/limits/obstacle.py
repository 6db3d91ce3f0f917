"""Distances between a robot and obstacles as a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.errors import LimitError, did_you_mean
from wbc.limits.distance import DistanceLimit
from wbc.limits.near_pairs import NearPairs
from wbc.robot import RobotModel
from wbc.robot.collision_shapes import collision_shapes, geometry_shapes


class ObstacleLimit(DistanceLimit):
    """Keeps the bodies of a robot away from obstacles, see `DistanceLimit`.

    Args:
        robot: the robot.
        obstacles: name -> geometry of coal (`coal.Box`, `Sphere`, `Capsule`, `Cylinder`, a mesh
            or a convex one; meshes count as their convex hulls) and its placement in the world.
        bodies: names of the joints whose bodies are kept away; all that have shapes and are no
            feet when left out.
        margin: distance that is kept, m.
        detection: pairs farther apart than that are left aside, m.
        size: largest number of rows, those of the nearest pairs first.
        gain, recovery, priority, weight: see `BarrierLimit`.

    Raises:
        LimitError: a geometry without bounds or volume, no obstacle, no body with a shape, or see
            `DistanceLimit`.
        JointNotFound: one of the bodies is missing.
    """

    def __init__(
        self,
        robot: RobotModel,
        obstacles: Mapping[str, tuple[Any, pin.SE3]],
        *,
        bodies: Sequence[str] | None = None,
        margin: float = 0.02,
        detection: float = 0.1,
        size: int = 40,
        gain: float = 20.0,
        recovery: float = 0.1,
        priority: int = 0,
        weight: float = 1.0,
        name: str = "obstacle limit",
    ) -> None:
        if bodies is None:
            feet = {sole.joint_id for sole in getattr(robot, "soles", ())}
            moving = [s for s in collision_shapes(robot) if s.joint_id not in feet]
        else:
            joints = {robot.joint_index(body) + 2 for body in bodies}
            moving = [s for s in collision_shapes(robot) if s.joint_id in joints]
        self._fixed = []
        for what, (geometry, placement) in obstacles.items():
            found = geometry_shapes(what, geometry, placement)
            if not found:
                raise LimitError(
                    f"{name}: obstacle '{what}' ({type(geometry).__name__}) must be a box, sphere, "
                    "capsule, cylinder or mesh with a volume"
                )
            self._fixed += found
        if not moving or not self._fixed:
            raise LimitError(
                f"{name}: there is nothing to keep apart: {len(moving)} shapes of the robot, "
                f"{len(self._fixed)} obstacles"
            )
        self._moving = len(moving)
        n = len(moving)
        pairs = np.array([(i, n + j) for i in range(n) for j in range(len(self._fixed))])
        links = [shape.link for shape in (*moving, *self._fixed)]
        super().__init__(
            name,
            robot,
            NearPairs([*moving, *self._fixed], pairs),
            [f"{links[i]} – {links[j]}" for i, j in pairs],
            np.full(len(pairs), margin),
            detection,
            size,
            gain,
            recovery,
            priority,
            weight,
        )
        self.margin = margin

    def place(self, obstacle: str, placement: pin.SE3) -> None:
        """Move an obstacle; its speed counts as zero.

        Args:
            obstacle: its name.
            placement: in the world.

        Raises:
            LimitError: there is no obstacle of that name.
        """
        names = [shape.link for shape in self._fixed]
        if obstacle not in names:
            raise LimitError(
                f"limit '{self.name}': there is no obstacle '{obstacle}'"
                f"{did_you_mean(obstacle, names)}"
            )
        k = names.index(obstacle)
        self._fixed[k] = replace(self._fixed[k], placement=placement)
        self._near.place(self._moving + k, self._fixed[k])
