"""Places that both hands can reach at once, drawn at random."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wbc.errors import MotionError
from wbc.ik.posture_checks import holding_effort
from wbc.ik.posture_ik import PostureIK
from wbc.robot.upper_body import Arm

_STRENGTH = 0.75  # share of any torque limit, at rest: the rest moves and balances
# Shares of the arm's length: how far a hand stays on its side of the body's middle,
_ASIDE = 0.05
_CLEAR = 0.45  # from the trunk's vertical axis and from the other hand,
_BEHIND = 0.1  # and how far behind the shoulder it may be
_LEAST, _MOST = 0.15, 0.85  # share of each joint's range that samples are drawn from
_WIDEST = 2.6  # rad either way
_TRIES = 1000  # per place

Places = Mapping[str, np.ndarray]  # hand frame -> (3,) in the standing frame, m


@dataclass(frozen=True)
class SampledPlaces:
    """Places for hands, and the posture that shows that they can be reached.

    Attributes:
        places: hand frame -> (3,) standing frame, m.
        q: (nq,) standing upright, the hands at the places; None when nobody knows one.
    """

    places: Places
    q: np.ndarray | None


@dataclass
class PlaceSampler:
    """Draws postures of the arms from the middle of their joints' ranges.

    A posture does not count whose hands are behind the body, across its middle, in the trunk or
    at each other, nor one that takes more than 75 % of any joint's torque at rest. Nothing else
    is left out: whatever else there is against a place, it is drawn.

    Attributes:
        ik: for the robot.
        seed: of the draw.
        tried: postures that were drawn.
        in_the_way: of these, with a hand where the body is.
        too_heavy: of the rest, those that the joints are too weak to hold.
    """

    ik: PostureIK
    seed: int
    tried: int = 0
    in_the_way: int = 0
    too_heavy: int = 0

    def places(self, count: int) -> list[SampledPlaces]:
        """So many places.

        Raises:
            MotionError: hardly any posture is fit.
        """
        found: list[SampledPlaces] = []
        for drawn in self._postures(_TRIES * count):
            found.append(drawn)
            if len(found) == count:
                return found
        raise MotionError(
            f"reach: {self.ik.robot.name}'s hands reach hardly anything in front of it: of "
            f"{self.tried} postures {self.in_the_way} have a hand at the body, {self.too_heavy} "
            "are too heavy"
        )

    def __str__(self) -> str:
        fit = self.tried - self.in_the_way - self.too_heavy
        return (
            f"{fit} random places for both hands, of {self.tried} drawn postures of the arms; in "
            f"{self.in_the_way} a hand is at the body or on the wrong side, {self.too_heavy} take "
            f"more than {100.0 * _STRENGTH:.0f} % of a joint's torque at rest"
        )

    def _postures(self, tries: int) -> Iterator[SampledPlaces]:
        ik, robot = self.ik, self.ik.robot
        random = np.random.default_rng(self.seed)
        arms = ik.upper_body.both_arms()
        for _ in range(tries):
            self.tried += 1
            q = robot.q_nominal.copy()
            for arm in arms:
                joints = np.array(arm.joints)
                ends = (robot.q_min[joints], robot.q_max[joints])
                low, high = (np.clip(end, -_WIDEST, _WIDEST) for end in ends)
                share = random.uniform(_LEAST, _MOST, joints.size)
                q[7 + joints] = low + share * (high - low)
            places = {arm.hand: ik.place(arm.hand, q) for arm in arms}
            if not _is_clear(ik, arms, places):
                self.in_the_way += 1
            elif holding_effort(robot, q).ratio >= _STRENGTH:
                self.too_heavy += 1
            else:
                yield SampledPlaces(places, q)


def _is_clear(ik: PostureIK, arms: tuple[Arm, Arm], places: Places) -> bool:
    left, right = (places[arm.hand] for arm in arms)
    axis = ik.place(ik.robot.torso)
    length = arms[0].length
    for arm, place in zip(arms, (left, right), strict=True):
        outward = 1.0 if arm.side == "left" else -1.0
        shoulder = ik.place(arm.shoulder)
        if outward * place[1] < _ASIDE * length:
            return False
        if place[0] < shoulder[0] - _BEHIND * length:
            return False
        if np.hypot(*(place - axis)[:2]) < _CLEAR * length:
            return False
    return bool(np.linalg.norm(left - right) > _CLEAR * length)
