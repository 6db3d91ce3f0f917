"""Which pairs of a robot's bodies cannot collide in earnest, by the geometry of its description."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.robot.collision_shapes import CollisionShape
from wbc.robot.robot_model import RobotModel
from wbc.robot.srdf import read_disabled_collisions

#: Number of random postures in which the overlap of neighbours is looked for.
_SAMPLES = 300
_SEED = 0
#: Largest share of the random postures in which bodies so many joints apart may overlap and
#: collide nevertheless. The ranges of the joints between keep real bodies apart that are nearer.
_MAX_SHARE = {1: 0.0, 2: 0.0, 3: 0.5}
#: A joint without limits is sampled from −π to π, rad.
_TURN = np.pi

PairReason = Literal["adjacent", "SRDF", "nominal posture", "joint range"]
#: Returns the pairs of joint ids, the smaller first, whose bodies overlap in a posture (nq,).
Overlaps = Callable[[np.ndarray], set[tuple[int, int]]]


@dataclass(frozen=True, slots=True)
class ExcludedPair:
    """Two bodies whose contact and distance are left out of account.

    Attributes:
        first: name of the joint that moves the one body.
        second: likewise the other.
        reason: "adjacent": only joints lie between them, no other shape; "SRDF": the semantic
            description says so; "nominal posture": their shapes overlap there; "joint range":
            the shapes of neighbours overlap in other postures (see `excluded_pairs`).
    """

    first: str
    second: str
    reason: PairReason


def known_pairs(
    robot: RobotModel, shapes: Sequence[CollisionShape], joints: Sequence[int]
) -> dict[tuple[int, int], PairReason]:
    """Return the pairs of joint ids that are excluded without a look at any posture.

    Args:
        robot: the robot.
        shapes: its shapes.
        joints: ids of the joints that move bodies with shapes, ascending.
    """
    reasons: dict[tuple[int, int], PairReason] = dict.fromkeys(
        _adjacent(robot.model, joints), "adjacent"
    )
    for pair in _disabled_by_srdf(robot, shapes):
        reasons.setdefault(pair, "SRDF")
    return reasons


def excluded_pairs(
    robot: RobotModel, known: dict[tuple[int, int], PairReason], overlaps: Overlaps
) -> tuple[ExcludedPair, ...]:
    """Return the pairs of bodies that are left out of account, and why.

    Pairs are excluded as generators of semantic descriptions do it (D. Coleman, I. Sucan,
    S. Chitta, N. Correll, *Reducing the barrier to entry of complex robotic software: a MoveIt!
    case study*, JOSER 2014): bodies joined to each other, those that the robot's SRDF names,
    and those whose shapes overlap in the nominal posture. Further those that overlap in 300
    postures, drawn uniformly from the joints' ranges: bodies two joints apart that do so in any
    posture, because a robot's joint limits keep such neighbours apart and convex shapes are larger
    than bodies; and bodies three joints apart that do so in more than half of the postures.
    Bodies that are farther apart and often overlap really would collide.

    Args:
        robot: the robot.
        known: see `known_pairs`.
        overlaps: finds the pairs of bodies that overlap in a posture, other than the known.
    """
    reasons = dict(known)
    for pair in overlaps(robot.q_nominal):
        reasons.setdefault(pair, "nominal posture")
    for pair in _frequent(robot, overlaps):
        reasons.setdefault(pair, "joint range")
    names = robot.model.names
    return tuple(ExcludedPair(names[a], names[b], why) for (a, b), why in sorted(reasons.items()))


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


def _frequent(robot: RobotModel, overlaps: Overlaps) -> list[tuple[int, int]]:
    """Return pairs of near bodies that overlap in too many of the random postures."""
    random = np.random.default_rng(_SEED)
    low, high = np.maximum(robot.q_min, -_TURN), np.minimum(robot.q_max, _TURN)
    counts: Counter[tuple[int, int]] = Counter()
    q = robot.q_nominal.copy()
    for _ in range(_SAMPLES):
        q[7:] = random.uniform(low, high)
        counts.update(overlaps(q))
    return [
        pair
        for pair, count in counts.items()
        if count > _SAMPLES * _MAX_SHARE.get(_joints_between(robot.model, *pair), 1.0)
    ]


def _joints_between(model: pin.Model, first: int, second: int) -> int:
    one, other = set(model.supports[first]), set(model.supports[second])
    return len(one ^ other)
