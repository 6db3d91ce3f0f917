"""The plan of a reaching motion: positions one after the other, and postures on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wbc.ik.objective import PostureSolution
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.arm_paths import ArmPaths
from wbc.motions.reaching.closest_posture import closest_posture
from wbc.motions.reaching.place_sampler import HandPlaces, PlaceSampler
from wbc.robot import Robot
from wbc.robot.upper_body import Side


@dataclass(frozen=True)
class ReachTarget:
    """Positions of the hands, as near to the desired ones as the robot can.

    Attributes:
        path: postures one after the other; more than one where the straight path is too heavy
            for the arms.
        places: side -> (3,) position of the hand, standing frame, m.
        out_of_reach: side -> text about a position that is out of reach.
        known_reachable: whether a posture is known that reaches the positions.
    """

    path: tuple[PostureSolution, ...]
    places: Mapping[Side, np.ndarray]
    out_of_reach: Mapping[Side, str]
    known_reachable: bool


@dataclass(frozen=True)
class ReachPlan:
    """Targets of the hands, one after the other.

    Attributes:
        targets: targets, in this order.
        return_path: postures between the last target and standing.
        note: remark on the sampling of the positions; empty if they were given.
    """

    targets: tuple[ReachTarget, ...]
    return_path: tuple[PostureSolution, ...]
    note: str

    def __repr__(self) -> str:
        missed = sum(len(target.out_of_reach) for target in self.targets)
        return f"ReachPlan({len(self.targets)} targets, {missed} positions out of reach)"


def plan_reach(
    robot: Robot, given: Mapping[str, tuple[float, ...]], count: int, seed: int
) -> ReachPlan:
    """Plan reaching for given positions, or for random ones if none is given.

    Args:
        robot: the robot.
        given: side -> position of the hand, standing frame, m.
        count: number of random positions.
        seed: seed of the random positions.

    Raises:
        MotionError: the robot lacks an arm, or its hands reach hardly anything.
    """
    ik = PostureIK(robot)
    paths = ArmPaths(ik)
    sampler = PlaceSampler(ik, seed)
    if given:
        places = {ik.upper_body.arm(side).hand: np.array(p) for side, p in given.items()}
        desired = [HandPlaces(places, None)]
    else:
        desired = sampler.sample(count)
    targets: list[ReachTarget] = []
    before = ik.standing
    for one in desired:
        targets.append(_target(ik, paths, one, before))
        before = targets[-1].path[-1]
    return_path = paths.between(before, ik.standing)[:-1]
    return ReachPlan(tuple(targets), return_path, "" if given else str(sampler))


def _target(
    ik: PostureIK, paths: ArmPaths, desired: HandPlaces, before: PostureSolution
) -> ReachTarget:
    """Return the posture closest to desired positions, and the path there from another posture."""
    found = closest_posture(ik, desired)
    places: dict[Side, np.ndarray] = {}
    out_of_reach: dict[Side, str] = {}
    for arm in ik.upper_body.arms:
        if arm.hand in found.out_of_reach:
            out_of_reach[arm.side] = found.out_of_reach[arm.hand]
        if arm.hand in found.places:
            places[arm.side] = found.places[arm.hand]
    path = paths.between(before, found.posture)
    return ReachTarget(path, places, out_of_reach, desired.q is not None)
