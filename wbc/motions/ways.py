"""Ways between postures that the joints are strong enough for."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from wbc.errors import MotionError
from wbc.motions.posing import Posing
from wbc.motions.reachable import Draw
from wbc.motions.statics import STRENGTH, hardest
from wbc.motions.wish import Pose, Wish

_OTHERS = 40  # postures that a way may lead over


class Ways:
    """Finds ways of one or two straight pieces in joint space, as light as need be.

    A stretched arm is heaviest when it is level: what cannot be lifted straight can be lifted
    with the elbow bent first. The postures in between are drawn at random, always the same ones.

    Args:
        posing: for the robot.
    """

    def __init__(self, posing: Posing) -> None:
        self._posing = posing
        # By the identity of the posture, which its way keeps alive: each is come to and left.
        self._known: dict[int, tuple[Pose, ...]] = {}

    def between(self, before: Pose, after: Pose) -> tuple[Pose, ...]:
        """Postures to go to one after the other, `after` last; over standing when need be."""
        if self._heaviest(before, after) <= STRENGTH:
            return (after,)
        home = self._posing.home
        stops = [*reversed(self._from_home(before)), home, *self._from_home(after)]
        return tuple(now for last, now in pairwise(stops) if now is not last)

    def _from_home(self, pose: Pose) -> tuple[Pose, ...]:
        if id(pose) not in self._known:
            self._known[id(pose)] = self._find(pose)
        return self._known[id(pose)]

    def _find(self, pose: Pose) -> tuple[Pose, ...]:
        """Straight, or over the posture nearest to both ends that makes it light enough."""
        home = self._posing.home
        way: tuple[Pose, ...] = (pose,)
        lightest = self._heaviest(home, pose)
        if lightest <= STRENGTH:
            return way

        def detour(over: Pose) -> float:
            return sum(float(np.abs(over.q[7:] - end.q[7:]).max()) for end in (home, pose))

        for over in sorted(self._others, key=detour):
            heaviest = max(self._heaviest(home, over), self._heaviest(over, pose))
            if heaviest < lightest:
                lightest, way = heaviest, (over, pose)
            if lightest <= STRENGTH:
                break
        return way

    def _heaviest(self, start: Pose, end: Pose) -> float:
        return hardest(self._posing.robot, start.q, end.q).ratio

    @cached_property
    def _others(self) -> list[Pose]:
        arms = tuple(j for arm in self._posing.anatomy.arms for j in arm.joints)
        wish = Wish(firm=True, firm_com=True, kept=arms)
        try:
            drawn = Draw(self._posing, 0).places(_OTHERS)
        except MotionError:  # one arm only, or none
            return []
        return [self._posing.find(wish, one.q) for one in drawn]
