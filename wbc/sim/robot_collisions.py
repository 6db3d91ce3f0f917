"""What of a robot collides in the plant: the shapes of its bodies, and which pairs pass through."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wbc.robot import Robot
from wbc.robot.collision_pairs import ExcludedPair, excluded_pairs, known_pairs
from wbc.robot.collision_shapes import CollisionShape, collision_shapes
from wbc.robot.computed_once import computed_once
from wbc.sim.coordinates import CoordinateMap
from wbc.sim.model import build_model, import_mujoco
from wbc.state import State


@dataclass(frozen=True, slots=True, eq=False)
class RobotCollisions:
    """The shapes of a robot's bodies, and the pairs of bodies that do not collide.

    Attributes:
        shapes: all shapes but the soles.
        excluded_pairs: pairs that pass through each other; all others collide.
    """

    shapes: tuple[CollisionShape, ...] = ()
    excluded_pairs: tuple[ExcludedPair, ...] = ()

    def __str__(self) -> str:
        sources = Counter(shape.source for shape in self.shapes)
        reasons = Counter(pair.reason for pair in self.excluded_pairs)
        return (
            f"{len(self.shapes)} shapes ({_counts(sources)}); "
            f"{len(self.excluded_pairs)} pairs of bodies do not collide ({_counts(reasons)})"
        )


def _counts(found: Counter[Any]) -> str:
    return ", ".join(f"{count} {name}" for name, count in found.items()) or "none"


@computed_once
def robot_collisions(robot: Robot) -> RobotCollisions:
    """Return the shapes and the pairs of a robot, computed once per robot.

    See `wbc.robot.collision_pairs.excluded_pairs`; the soles count as shapes of their bodies.
    """
    shapes = collision_shapes(robot)
    joints = sorted({shape.joint_id for shape in shapes} | {s.joint_id for s in robot.soles})
    known = known_pairs(robot, shapes, joints)
    return RobotCollisions(shapes, excluded_pairs(robot, known, _Overlaps(robot, shapes, known)))


class _Overlaps:
    """Finds the bodies that overlap in a posture, other than given pairs."""

    def __init__(
        self, robot: Robot, shapes: Sequence[CollisionShape], excluded: Iterable[tuple[int, int]]
    ) -> None:
        self._robot = robot
        self._mujoco = import_mujoco()
        names = robot.model.names
        self._model = build_model(
            robot, shapes=shapes, excluded_pairs=[(names[a], names[b]) for a, b in excluded]
        )
        self._data = self._mujoco.MjData(self._model)
        dofs = [self._model.joint(name).dofadr[0] - 6 for name in robot.joint_names]
        self._coordinates = CoordinateMap(np.array(dofs, dtype=int))
        # Pinocchio's joint id of each of MuJoCo's bodies; both begin with the world.
        self._joint_ids = [
            robot.model.getJointId(self._model.body(i).name) if i else 0
            for i in range(robot.model.njoints)
        ]

    def __call__(self, q: np.ndarray) -> set[tuple[int, int]]:
        """Return pairs of joint ids, the smaller first."""
        mujoco, model, data = self._mujoco, self._model, self._data
        high = q.copy()
        high[2] += 100.0  # off the ground
        state = State(high, np.zeros(self._robot.nv))
        data.qpos[:], _ = self._coordinates.to_plant(state)
        mujoco.mj_fwdPosition(model, data)
        return {
            (min(a, b), max(a, b))
            for a, b in (
                (self._joint_ids[first], self._joint_ids[second])
                for first, second in touching_bodies(model, data)
            )
        }


def touching_bodies(model: Any, data: Any) -> set[tuple[int, int]]:
    """Return the pairs of MuJoCo body ids of the robot that touch each other."""
    contact = data.contact
    bodies = model.geom_bodyid[contact.geom[contact.dist < 0.0]]
    roots = model.body_rootid[bodies]
    return set(map(tuple, bodies[roots[:, 0] == roots[:, 1]].tolist()))
