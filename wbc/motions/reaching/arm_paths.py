"""Paths between postures that the joints are strong enough for, and on which no bodies touch."""

from __future__ import annotations

import math
from functools import cached_property
from itertools import pairwise

import numpy as np
import pinocchio as pin

from wbc.errors import MotionError
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_checks import MAX_TORQUE_SHARE, max_effort_along
from wbc.ik.posture_ik import PostureIK
from wbc.motions.reaching.place_sampler import PlaceSampler

_WAYPOINTS = 40  # candidates for the posture that a path leads over
_CHECKED_SHARES = np.linspace(0.1, 0.9, 9)  # of a path, at which bodies must not touch


class ArmPaths:
    """Finds paths of one or two straight segments in joint space within torque limits, and clear.

    A stretched arm is heaviest when it is level: what cannot be lifted straight can be lifted
    with the elbow bent first. Candidates for waypoints are sampled, always the same ones.

    Args:
        ik: inverse kinematics of the robot.
    """

    def __init__(self, ik: PostureIK) -> None:
        self._ik = ik
        # By the identity of the posture, which its path keeps alive: each is used twice.
        self._from_standing: dict[int, tuple[PostureSolution, ...]] = {}

    def between(
        self, before: PostureSolution, after: PostureSolution
    ) -> tuple[PostureSolution, ...]:
        """Return the postures to go to, `after` last; over standing if necessary."""
        if self._max_effort(before, after) <= MAX_TORQUE_SHARE:
            return (after,)
        standing = self._ik.standing
        stops = [*reversed(self._path_from_standing(before)), standing]
        stops += self._path_from_standing(after)
        return tuple(now for last, now in pairwise(stops) if now is not last)

    def _path_from_standing(self, posture: PostureSolution) -> tuple[PostureSolution, ...]:
        if id(posture) not in self._from_standing:
            self._from_standing[id(posture)] = self._find(posture)
        return self._from_standing[id(posture)]

    def _find(self, posture: PostureSolution) -> tuple[PostureSolution, ...]:
        """Return the straight path, or one over the nearest waypoint that makes it light enough."""
        standing = self._ik.standing
        path: tuple[PostureSolution, ...] = (posture,)
        least = self._max_effort(standing, posture)
        if least <= MAX_TORQUE_SHARE:
            return path

        def detour(waypoint: PostureSolution) -> float:
            ends = (standing, posture)
            return sum(float(np.abs(waypoint.q[7:] - end.q[7:]).max()) for end in ends)

        for waypoint in sorted(self._waypoints, key=detour):
            effort = max(self._max_effort(standing, waypoint), self._max_effort(waypoint, posture))
            if effort < least:
                least, path = effort, (waypoint, posture)
            if least <= MAX_TORQUE_SHARE:
                break
        return path

    def _max_effort(self, start: PostureSolution, end: PostureSolution) -> float:
        """Return the largest share of a torque on a straight path, ∞ if bodies touch on it."""
        model = self._ik.robot.model
        for share in _CHECKED_SHARES:
            if self._ik.self_contact(pin.interpolate(model, start.q, end.q, share)):
                return math.inf
        return max_effort_along(self._ik.robot, start.q, end.q).ratio

    @cached_property
    def _waypoints(self) -> list[PostureSolution]:
        arms = tuple(j for arm in self._ik.upper_body.arms for j in arm.joints)
        objective = PostureObjective(strict_trunk=True, strict_com=True, fixed_joints=arms)
        try:
            sampled = PlaceSampler(self._ik, 0).sample(_WAYPOINTS)
        except MotionError:  # one arm only, or none
            return []
        return [self._ik.solve(objective, one.q) for one in sampled]
