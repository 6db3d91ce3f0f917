"""ArmPaths between postures that the joints are strong enough for."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import MAX_TORQUE_SHARE, max_effort_along
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.place_sampler import PlaceSampler

_OTHERS = 40  # postures that a way may lead over


class ArmPaths:
    """Finds ways of one or two straight pieces in joint space, as light as need be.

    A stretched arm is heaviest when it is level: what cannot be lifted straight can be lifted
    with the elbow bent first. The postures in between are drawn at random, always the same ones.

    Args:
        ik: for the robot.
    """

    def __init__(self, ik: PostureIK) -> None:
        self._posing = ik
        # By the identity of the posture, which its way keeps alive: each is come to and left.
        self._known: dict[int, tuple[PostureSolution, ...]] = {}

    def between(
        self, before: PostureSolution, after: PostureSolution
    ) -> tuple[PostureSolution, ...]:
        """Postures to go to one after the other, `after` last; over standing when need be."""
        if self._heaviest(before, after) <= MAX_TORQUE_SHARE:
            return (after,)
        home = self._posing.home
        stops = [*reversed(self._from_home(before)), home, *self._from_home(after)]
        return tuple(now for last, now in pairwise(stops) if now is not last)

    def _from_home(self, pose: PostureSolution) -> tuple[PostureSolution, ...]:
        if id(pose) not in self._known:
            self._known[id(pose)] = self._find(pose)
        return self._known[id(pose)]

    def _find(self, pose: PostureSolution) -> tuple[PostureSolution, ...]:
        """Straight, or over the posture nearest to both ends that makes it light enough."""
        home = self._posing.home
        way: tuple[PostureSolution, ...] = (pose,)
        lightest = self._heaviest(home, pose)
        if lightest <= MAX_TORQUE_SHARE:
            return way

        def detour(over: PostureSolution) -> float:
            return sum(float(np.abs(over.q[7:] - end.q[7:]).max()) for end in (home, pose))

        for over in sorted(self._others, key=detour):
            heaviest = max(self._heaviest(home, over), self._heaviest(over, pose))
            if heaviest < lightest:
                lightest, way = heaviest, (over, pose)
            if lightest <= MAX_TORQUE_SHARE:
                break
        return way

    def _heaviest(self, start: PostureSolution, end: PostureSolution) -> float:
        return max_effort_along(self._posing.robot, start.q, end.q).ratio

    @cached_property
    def _others(self) -> list[PostureSolution]:
        arms = tuple(j for arm in self._posing.upper_body.arms for j in arm.joints)
        objective = PostureObjective(firm=True, firm_com=True, kept=arms)
        try:
            drawn = PlaceSampler(self._posing, 0).places(_OTHERS)
        except MotionError:  # one arm only, or none
            return []
        return [self._posing.find(objective, one.q) for one in drawn]
