"""Random positions that both hands can reach at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wbc.errors import MotionError
from wbc.ik.posture_checks import holding_effort
from wbc.ik.posture_ik import PostureIK
from wbc.robot.upper_body import Arm

_MAX_TORQUE_SHARE = 0.75  # of any torque limit, at rest: the rest moves and balances
# Shares of the arm's length: how far a hand stays on its side of the robot's middle,
_OUTWARD = 0.05
_CLEARANCE = 0.45  # from the trunk's vertical axis and from the other hand,
_BEHIND = 0.1  # and how far behind the shoulder it may be
_LOW, _HIGH = 0.15, 0.85  # share of each joint's range that samples are taken from
_MAX_ANGLE = 2.6  # rad either way
_TRIES = 1000  # per position

Places = Mapping[str, np.ndarray]  # hand frame -> (3,) in the standing frame, m


@dataclass(frozen=True)
class HandPlaces:
    """Positions of the hands, and a posture that reaches them if one is known.

    Attributes:
        places: hand frame -> (3,) standing frame, m.
        q: (nq,) standing upright with the hands at the positions; None if none is known.
    """

    places: Places
    q: np.ndarray | None


@dataclass
class PlaceSampler:
    """Samples postures of the arms from the middle of their joints' ranges.

    A posture is rejected if a hand is behind the robot, across its middle, in the trunk or at
    the other hand, if bodies of the robot touch each other, or if it takes more than 75 % of any
    joint's torque at rest. No other criterion applies.

    Attributes:
        ik: inverse kinematics of the robot.
        seed: seed of the samples.
        tried: number of postures sampled.
        colliding: number of these in which bodies touch, or with a hand where the body or the
            other hand is.
        too_heavy: number of the rest that the joints are too weak to hold.
    """

    ik: PostureIK
    seed: int
    tried: int = 0
    colliding: int = 0
    too_heavy: int = 0

    def sample(self, count: int) -> list[HandPlaces]:
        """Return that many positions of both hands.

        Raises:
            MotionError: hardly any posture is acceptable.
        """
        found: list[HandPlaces] = []
        for sampled in self._acceptable(_TRIES * count):
            found.append(sampled)
            if len(found) == count:
                return found
        raise MotionError(
            f"reach: {self.ik.robot.name}'s hands reach hardly anything in front of it: of "
            f"{self.tried} postures {self.colliding} have touching bodies or a hand at the body, "
            f"{self.too_heavy} are too heavy"
        )

    def __str__(self) -> str:
        accepted = self.tried - self.colliding - self.too_heavy
        return (
            f"{accepted} random positions for both hands, of {self.tried} sampled postures of the "
            f"arms; in {self.colliding} bodies touch or a hand is at the body or on the wrong "
            f"side, {self.too_heavy} take more than {100.0 * _MAX_TORQUE_SHARE:.0f} % of a joint's "
            "torque at rest"
        )

    def _acceptable(self, tries: int) -> Iterator[HandPlaces]:
        ik, robot = self.ik, self.ik.robot
        random = np.random.default_rng(self.seed)
        arms = ik.upper_body.both_arms()
        for _ in range(tries):
            self.tried += 1
            q = robot.q_nominal.copy()
            for arm in arms:
                joints = np.array(arm.joints)
                ends = (robot.q_min[joints], robot.q_max[joints])
                low, high = (np.clip(end, -_MAX_ANGLE, _MAX_ANGLE) for end in ends)
                share = random.uniform(_LOW, _HIGH, joints.size)
                q[7 + joints] = low + share * (high - low)
            places = {arm.hand: ik.frame_position(arm.hand, q) for arm in arms}
            if not _is_clear(ik, arms, places) or ik.self_contact(q):
                self.colliding += 1
            elif holding_effort(robot, q).ratio >= _MAX_TORQUE_SHARE:
                self.too_heavy += 1
            else:
                yield HandPlaces(places, q)


def _is_clear(ik: PostureIK, arms: tuple[Arm, Arm], places: Places) -> bool:
    """Return whether the hands are in front, on their sides, and clear of trunk and each other."""
    left, right = (places[arm.hand] for arm in arms)
    axis = ik.frame_position(ik.robot.torso)
    length = arms[0].length
    for arm, place in zip(arms, (left, right), strict=True):
        outward = 1.0 if arm.side == "left" else -1.0
        shoulder = ik.frame_position(arm.shoulder)
        if outward * place[1] < _OUTWARD * length:
            return False
        if place[0] < shoulder[0] - _BEHIND * length:
            return False
        if np.hypot(*(place - axis)[:2]) < _CLEARANCE * length:
            return False
    return bool(np.linalg.norm(left - right) > _CLEARANCE * length)
