"""Which bodies of a robot collide with each other, and with what shapes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from wbc.robot import Robot
from wbc.robot.collision_shapes import CollisionShape, collision_shapes
from wbc.robot.srdf import read_disabled_collisions
from wbc.sim.coordinates import CoordinateMap
from wbc.sim.model import build_model, import_mujoco
from wbc.state import State

#: Number of random postures in which the overlap of neighbours is looked for.
_SAMPLES = 200
#: Largest share of the random postures in which bodies so many joints apart may overlap and
#: collide nevertheless. The ranges of the two joints keep real bodies apart that are closer.
_MAX_SHARE = {1: 0.0, 2: 0.0, 3: 0.5}
#: A joint without limits is sampled from −π to π, rad.
_TURN = np.pi

PairReason = Literal["adjacent", "SRDF", "nominal posture", "joint range"]


@dataclass(frozen=True, slots=True)
class DisabledPair:
    """Two bodies that do not collide with each other.

    Attributes:
        first: name of the Pinocchio joint that moves the one body.
        second: likewise the other.
        reason: "adjacent": only joints lie between them, no other shape; "SRDF": its semantic
            description says so; "nominal posture": their shapes overlap there; "joint range":
            the shapes of neighbours overlap in other postures (see `robot_collisions`).
    """

    first: str
    second: str
    reason: PairReason


@dataclass(frozen=True, slots=True, eq=False)
class RobotCollisions:
    """The shapes of a robot's bodies, and the pairs of bodies that do not collide.

    Attributes:
        shapes: all shapes but the soles.
        disabled_pairs: pairs that pass through each other; all others collide.
    """

    shapes: tuple[CollisionShape, ...] = ()
    disabled_pairs: tuple[DisabledPair, ...] = ()

    def __str__(self) -> str:
        sources = Counter(shape.source for shape in self.shapes)
        reasons = Counter(pair.reason for pair in self.disabled_pairs)
        return (
            f"{len(self.shapes)} shapes ({_counts(sources)}); "
            f"{len(self.disabled_pairs)} pairs of bodies do not collide ({_counts(reasons)})"
        )


def _counts(found: Counter[Any]) -> str:
    return ", ".join(f"{count} {name}" for name, count in found.items()) or "none"


_found: WeakKeyDictionary[Robot, RobotCollisions] = WeakKeyDictionary()


def robot_collisions(robot: Robot) -> RobotCollisions:
    """Return the shapes and the pairs of a robot, computed once per robot.

    Pairs are disabled as generators of semantic descriptions do it (D. Coleman, I. Sucan,
    S. Chitta, N. Correll, *Reducing the barrier to entry of complex robotic software: a MoveIt!
    case study*, JOSER 2014): bodies joined to each other, those that the robot's SRDF names,
    and those whose shapes overlap in the nominal posture. Further those that overlap in 200
    postures, drawn uniformly from the joints' ranges: bodies two joints apart that do so in any
    posture, because a robot's joint limits keep such neighbours apart and convex shapes are larger
    than bodies; and bodies three joints apart that do so in more than half of the postures.
    Bodies that are farther apart and often overlap really would collide.
    """
    collisions = _found.get(robot)
    if collisions is None:
        collisions = _found[robot] = _robot_collisions(robot)
    return collisions


def _robot_collisions(robot: Robot) -> RobotCollisions:
    shapes = collision_shapes(robot)
    joints = sorted({shape.joint_id for shape in shapes} | {s.joint_id for s in robot.soles})
    reasons: dict[tuple[int, int], PairReason] = {}
    for pair in _adjacent(robot.model, joints):
        reasons[pair] = "adjacent"
    for pair in _disabled_by_srdf(robot, shapes):
        reasons.setdefault(pair, "SRDF")
    overlaps = _Overlaps(robot, shapes, tuple(reasons))
    for pair in overlaps.of(robot.q_nominal):
        reasons.setdefault(pair, "nominal posture")
    for pair in overlaps.frequent():
        reasons.setdefault(pair, "joint range")
    names = robot.model.names
    pairs = (DisabledPair(names[a], names[b], why) for (a, b), why in sorted(reasons.items()))
    return RobotCollisions(shapes, tuple(pairs))


def _adjacent(model: pin.Model, joints: Sequence[int]) -> list[tuple[int, int]]:
    """Return each body with shapes and the next one with shapes on its way to the base."""
    found = []
    for joint in joints:
        parent = model.parents[joint]
        while parent > 0 and parent not in joints:
            parent = model.parents[parent]
        if parent > 0:
            found.append((int(parent), joint))
    return found


def _disabled_by_srdf(robot: Robot, shapes: Sequence[CollisionShape]) -> list[tuple[int, int]]:
    """Return the pairs of bodies all of whose links the SRDF disables."""
    if robot.srdf is None:
        return []
    disabled = read_disabled_collisions(robot.srdf)
    links: dict[int, set[str]] = {}
    for shape in shapes:
        links.setdefault(shape.joint_id, set()).add(shape.link)
    return [
        (a, b)
        for a in links
        for b in links
        if a < b and all(frozenset(two) in disabled for two in product(links[a], links[b]))
    ]


class _Overlaps:
    """Finds the bodies that overlap in a posture, other than given pairs."""

    def __init__(
        self, robot: Robot, shapes: Sequence[CollisionShape], disabled: Sequence[tuple[int, int]]
    ) -> None:
        self._robot = robot
        self._mujoco = import_mujoco()
        names = robot.model.names
        self._model = build_model(
            robot, shapes=shapes, disabled_pairs=[(names[a], names[b]) for a, b in disabled]
        )
        self._data = self._mujoco.MjData(self._model)
        dofs = [self._model.joint(name).dofadr[0] - 6 for name in robot.joint_names]
        self._coordinates = CoordinateMap(np.array(dofs, dtype=int))
        # Pinocchio's joint id of each of MuJoCo's bodies; both begin with the world.
        self._joint_ids = [
            robot.model.getJointId(self._model.body(i).name) if i else 0
            for i in range(robot.model.njoints)
        ]

    def of(self, q: np.ndarray) -> set[tuple[int, int]]:
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

    def frequent(self) -> list[tuple[int, int]]:
        """Return pairs of near bodies that overlap in too many of the random postures."""
        robot, random = self._robot, np.random.default_rng(0)
        low, high = np.maximum(robot.q_min, -_TURN), np.minimum(robot.q_max, _TURN)
        counts: Counter[tuple[int, int]] = Counter()
        q = robot.q_nominal.copy()
        for _ in range(_SAMPLES):
            q[7:] = random.uniform(low, high)
            counts.update(self.of(q))
        return [
            pair
            for pair, count in counts.items()
            if count > _SAMPLES * _MAX_SHARE.get(_joints_between(robot.model, *pair), 1.0)
        ]


def touching_bodies(model: Any, data: Any) -> set[tuple[int, int]]:
    """Return the pairs of MuJoCo body ids of the robot that touch each other."""
    contact = data.contact
    bodies = model.geom_bodyid[contact.geom[contact.dist < 0.0]]
    roots = model.body_rootid[bodies]
    return set(map(tuple, bodies[roots[:, 0] == roots[:, 1]].tolist()))


def _joints_between(model: pin.Model, first: int, second: int) -> int:
    one, other = set(model.supports[first]), set(model.supports[second])
    return len(one ^ other)
