"""Distances between the bodies of a robot, and which pairs of bodies are watched."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, Literal
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from wbc.robot.collision_shapes import CollisionShape, collision_shapes
from wbc.robot.robot_model import RobotModel
from wbc.robot.srdf import read_disabled_collisions

_SAMPLES = 300  # random postures
_SEED = 0
_TURN = np.pi  # rad: range of a joint without limits
_OFTEN = 0.5  # share of postures in which neighbours three joints apart may overlap

PairReason = Literal["same body", "adjacent", "SRDF", "nominal posture", "joint range"]


@dataclass(frozen=True, slots=True)
class ExcludedPair:
    """Two bodies whose distance is not watched.

    Attributes:
        first: name of the joint that moves the one body.
        second: likewise the other.
        reason: "adjacent": only joints lie between them; "SRDF": the semantic description
            says so; "nominal posture": their shapes overlap there; "joint range": the shapes of
            neighbours overlap in many postures, see `SelfCollision.of`.
    """

    first: str
    second: str
    reason: PairReason


@dataclass(frozen=True, eq=False)
class SelfCollision:
    """The shapes of a robot's bodies, and the pairs of them whose distance is watched.

    Attributes:
        robot: the robot.
        shapes: convex shapes, see `collision_shapes`.
        geometry: Pinocchio's model of the shapes and pairs.
        pairs: (p, 2) indices of shapes, in the order of `geometry.collisionPairs`.
        excluded: pairs of bodies that are not watched, and why.
        nominal_distance: (p,) distance of each pair in the nominal posture, m.
    """

    robot: RobotModel
    shapes: tuple[CollisionShape, ...]
    geometry: pin.GeometryModel
    pairs: np.ndarray
    excluded: tuple[ExcludedPair, ...]
    nominal_distance: np.ndarray

    def __repr__(self) -> str:
        return f"SelfCollision('{self.robot.name}': {self.report()})"

    def report(self) -> str:
        """Return in one line what was chosen."""
        reasons = Counter(pair.reason for pair in self.excluded)
        why = ", ".join(f"{count} {reason}" for reason, count in reasons.items()) or "none"
        bodies = {tuple(sorted(map(self._joint, pair))) for pair in self.pairs}
        return (
            f"{len(self.shapes)} shapes, {len(bodies)} pairs of bodies watched "
            f"({len(self.pairs)} of shapes), {len(self.excluded)} not ({why})"
        )

    def pair_name(self, k: int) -> str:
        """Return the names of the two links of a pair."""
        first, second = (self.shapes[i].link for i in self.pairs[k])
        return f"{first} – {second}"

    @cached_property
    def _workspace(self) -> tuple[pin.Data, pin.GeometryData]:
        return self.robot.model.createData(), self.geometry.createData()

    def first_contact(self, q: np.ndarray, margin: float = 0.0) -> str:
        """Return the names of two bodies that are nearer than a margin; empty if none are.

        Pairs that are nearer than that in the nominal posture count where they overlap.

        Args:
            q: (nq,) posture.
            margin: m.
        """
        data, geometry_data = self._workspace
        for k, nominal in enumerate(self.nominal_distance):
            geometry_data.collisionRequests[k].security_margin = min(margin, 0.5 * float(nominal))
        model = self.robot.model
        if not pin.computeCollisions(model, data, self.geometry, geometry_data, q, True):
            return ""
        hits = (k for k, r in enumerate(geometry_data.collisionResults) if r.isCollision())
        return self.pair_name(next(hits))

    def _joint(self, shape: int) -> int:
        return self.shapes[shape].joint_id

    def __deepcopy__(self, memo: dict[int, Any]) -> SelfCollision:
        return self  # immutable, as the robot is

    def __reduce__(self) -> tuple[Any, ...]:
        return SelfCollision.of, (self.robot,)

    @staticmethod
    def of(robot: RobotModel) -> SelfCollision:
        """Return the shapes and pairs of a robot, computed once per robot.

        All pairs of bodies are watched except those joined to each other, those that the robot's
        SRDF disables, and those whose shapes overlap in the nominal posture (Coleman, Sucan,
        Chitta and Correll, Reducing the barrier to entry of complex robotic software: a MoveIt!
        case study, JOSER 2014). Further those that overlap in 300 postures drawn uniformly from
        the joints' ranges: bodies two joints apart that do so in any, and bodies three joints
        apart that do so in more than half: convex shapes are larger than bodies.
        """
        found = _found.get(robot)
        if found is None:
            found = _found[robot] = _choose(robot)
        return found

    def least_distance(self, q: np.ndarray) -> tuple[float, int]:
        """Return the least distance of all pairs in a posture (nq,), m, and the pair's index.

        Negative when two bodies overlap.
        """
        distances = self.distances(q)
        if not distances.size:
            return np.inf, -1
        k = int(np.argmin(distances))
        return float(distances[k]), k

    def distances(self, q: np.ndarray) -> np.ndarray:
        """Return the distances of all pairs in a posture (nq,), m."""
        data, geometry_data = self.robot.model.createData(), self.geometry.createData()
        pin.computeDistances(self.robot.model, data, self.geometry, geometry_data, q)
        return np.array([result.min_distance for result in geometry_data.distanceResults])


_found: WeakKeyDictionary[RobotModel, SelfCollision] = WeakKeyDictionary()


def coal_shape(shape: CollisionShape) -> Any:
    """Return coal's geometry of a shape."""
    import coal

    match shape.kind:
        case "box":
            return coal.Box(*(2.0 * np.array(shape.size)))
        case "sphere":
            return coal.Sphere(*shape.size)
        case "cylinder":
            return coal.Cylinder(shape.size[0], 2.0 * shape.size[1])
        case "capsule":
            return coal.Capsule(shape.size[0], 2.0 * shape.size[1])
    from scipy.spatial import ConvexHull

    hull = ConvexHull(shape.vertices)
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    center = shape.vertices.mean(axis=0)
    for vertex in shape.vertices:
        points.append(vertex)
    for a, b, c in hull.simplices:
        u, v, w = shape.vertices[[a, b, c]]
        outward = np.cross(v - u, w - u) @ (u - center) > 0.0
        triangles.append(coal.Triangle(*map(int, (a, b, c) if outward else (a, c, b))))
    return coal.Convex(points, triangles)


def _choose(robot: RobotModel) -> SelfCollision:
    shapes = collision_shapes(robot)
    geometry = pin.GeometryModel()
    for k, shape in enumerate(shapes):
        item = pin.GeometryObject(
            f"{shape.link}_{k}", shape.joint_id, shape.placement, coal_shape(shape)
        )
        geometry.addGeometryObject(item)
    joints = sorted({shape.joint_id for shape in shapes})
    reasons: dict[tuple[int, int], PairReason] = dict.fromkeys(
        _adjacent(robot.model, joints), "adjacent"
    )
    for pair in _disabled_by_srdf(robot, shapes):
        reasons.setdefault(pair, "SRDF")
    candidates = [
        (i, j)
        for i, j in combinations(range(len(shapes)), 2)
        if shapes[i].joint_id != shapes[j].joint_id and _bodies(shapes, (i, j)) not in reasons
    ]
    for i, j in candidates:
        geometry.addCollisionPair(pin.CollisionPair(i, j))
    data, geometry_data = robot.model.createData(), geometry.createData()

    def overlaps(q: np.ndarray) -> set[tuple[int, int]]:
        pin.computeCollisions(robot.model, data, geometry, geometry_data, q, False)
        hit = [k for k, r in enumerate(geometry_data.collisionResults) if r.isCollision()]
        return {_bodies(shapes, candidates[k]) for k in hit}

    for pair in overlaps(robot.q_nominal):
        reasons.setdefault(pair, "nominal posture")
    for pair in _frequent(robot, overlaps):
        reasons.setdefault(pair, "joint range")
    kept = [pair for pair in candidates if _bodies(shapes, pair) not in reasons]
    geometry.removeAllCollisionPairs()
    for i, j in kept:
        geometry.addCollisionPair(pin.CollisionPair(i, j))
    names = robot.model.names
    excluded = tuple(ExcludedPair(names[a], names[b], r) for (a, b), r in sorted(reasons.items()))
    pairs = np.array(kept, dtype=int).reshape(-1, 2)
    found = SelfCollision(robot, shapes, geometry, pairs, excluded, np.zeros(len(kept)))
    object.__setattr__(found, "nominal_distance", found.distances(robot.q_nominal))
    return found


def _bodies(shapes: Sequence[CollisionShape], pair: tuple[int, int]) -> tuple[int, int]:
    """Return the joint ids of a pair of shapes, the smaller first."""
    a, b = shapes[pair[0]].joint_id, shapes[pair[1]].joint_id
    return (a, b) if a < b else (b, a)


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


def _disabled_by_srdf(robot: RobotModel, shapes: Sequence[CollisionShape]) -> list[tuple[int, int]]:
    """Return the pairs of bodies all of whose links the SRDF disables."""
    if robot.srdf is None:
        return []
    disabled = read_disabled_collisions(robot.srdf)
    links: dict[int, set[str]] = {}
    for shape in shapes:
        links.setdefault(shape.joint_id, set()).add(shape.link)
    return [
        (a, b)
        for a, b in combinations(sorted(links), 2)
        if all(frozenset((one, other)) in disabled for one in links[a] for other in links[b])
    ]


def _frequent(robot: RobotModel, overlaps: Any) -> list[tuple[int, int]]:
    """Return pairs of near bodies that overlap in too many of the random postures."""
    random = np.random.default_rng(_SEED)
    low, high = np.maximum(robot.q_min, -_TURN), np.minimum(robot.q_max, _TURN)
    counts: Counter[tuple[int, int]] = Counter()
    q = robot.q_nominal.copy()
    for _ in range(_SAMPLES):
        q[7:] = random.uniform(low, high)
        counts.update(overlaps(q))
    most = {1: 0.0, 2: 0.0, 3: _OFTEN * _SAMPLES}
    return [
        pair
        for pair, count in counts.items()
        if count > most.get(_joints_between(robot.model, *pair), _SAMPLES)
    ]


def _joints_between(model: pin.Model, first: int, second: int) -> int:
    one, other = set(model.supports[first]), set(model.supports[second])
    return len(one ^ other)
