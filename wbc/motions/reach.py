"""Reach: both hands to places, as far as the robot can, in balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions.anatomy import Anatomy, Arm, Side
from wbc.motions.body import Body
from wbc.motions.motion import Motion, Script, once_per_robot, parameter, positive
from wbc.motions.posing import Pose, Posing, Wish
from wbc.motions.statics import effort, hardest
from wbc.robot import Robot

_REACHABLE = 0.003  # m: nearer than this the posture is on the place
_STRENGTH = 0.75  # share of any torque limit, at rest: the rest moves and balances
# Shares of the arm's length: how far a hand stays on its side of the body's middle,
_ASIDE = 0.05
_CLEAR = 0.45  # from the trunk's vertical axis and from the other hand,
_BEHIND = 0.1  # and how far behind the shoulder it may be
_LEAST, _MOST = 0.15, 0.85  # share of each joint's range that samples are drawn from
_LAST = 0.4  # s
_XYZ = ("X", "Y", "Z")

Places = Mapping[str, np.ndarray]  # hand frame -> (3,) in the standing frame, m


@dataclass(frozen=True)
class Reach(Motion):
    """Hands to places in the standing frame: origin midway between the soles, x forward.

    Without places it goes through random ones that both hands can reach at once. What is out
    of reach is said, with the distance that is left, and the hand goes as near as it can.
    """

    name: ClassVar[str] = "reach"
    summary: ClassVar[str] = "lead the hands to places, given or random"

    left: tuple[float, ...] | None = parameter(None, "place of the left hand, m", names=_XYZ)
    right: tuple[float, ...] | None = parameter(None, "place of the right hand, m", names=_XYZ)
    random: int = parameter(4, "how many random places when none is given")
    draw: int = parameter(0, "of the random places")
    seconds: float = parameter(1.5, "of each way, s, at least")
    hold: float = parameter(0.5, "at each place, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        positive(self, "random", "seconds", "hold")
        anatomy = Anatomy.of(robot)
        if self.left is None and self.right is None:
            anatomy.both_arms()
        for side, place in self._given():
            anatomy.arm(side)
            if len(place) != 3 or not np.isfinite(place).all():
                raise MotionError(f"reach: {side} = {place} must be three finite numbers, m")
        self._goals(robot)

    def _given(self) -> list[tuple[str, tuple[float, ...]]]:
        both = (("left", self.left), ("right", self.right))
        return [(side, place) for side, place in both if place is not None]

    @once_per_robot
    def _goals(self, robot: Robot) -> list[Goal]:
        posing = Posing(robot)
        given = {posing.anatomy.arm(s).hand: np.array(p) for s, p in self._given()}
        wishes = [given] if given else sample(posing, self.random, self.draw)
        goals: list[Goal] = []
        for places in wishes:
            before = goals[-1].pose if goals else posing.home
            goals.append(Goal.of(posing, places, before))
        return goals

    def play(self, body: Body) -> Script:
        """See `Motion.play`."""
        for goal in self._goals(body.robot):
            for side, text in goal.misses.items():
                body.note(f"{side} hand: {text}")
            # The joints lead the hands there, without singularities on the way; then the hands
            # are led the last millimetres.
            for hand in body.hands.values():
                hand.release(_LAST)
            for pose in goal.way:
                body.take(pose, self.seconds)
                yield from body.arrive(body.posture)
            for side, place in goal.places.items():
                body.reach(side, place, _LAST, counts=side not in goal.misses)
            yield from body.wait(_LAST + self.hold)
        yield from body.go_home(self.seconds)


@dataclass(frozen=True)
class Goal:
    """Places for the hands, as near as the robot can.

    Attributes:
        pose: whole posture.
        way: postures one after the other, this one last: where the straight way is too heavy for
            the arms, it goes by standing.
        places: side -> (3,) where the hand goes, standing frame, m.
        misses: side -> what is said of a place that is out of reach.
    """

    pose: Pose
    way: Sequence[Pose]
    places: Mapping[Side, np.ndarray]
    misses: Mapping[Side, str]

    @classmethod
    def of(cls, posing: Posing, wished: Places, before: Pose) -> Goal:
        """The posture nearest to wished places, coming from another posture."""
        pose = _posture(posing, wished)
        places: dict[Side, np.ndarray] = {}
        misses: dict[Side, str] = {}
        for arm in posing.anatomy.arms:
            if arm.hand not in wished:
                continue
            place, miss = wished[arm.hand], pose.misses[arm.hand]
            if miss > _REACHABLE:
                at = " ".join(f"{x:g}" for x in place)
                misses[arm.side] = f"({at}) m is out of reach by {1e3 * miss:.0f} mm"
                place = posing.place(arm.hand, pose.q)
            places[arm.side] = place
        heavy = hardest(posing.robot, before.q, pose.q).ratio > _STRENGTH
        return cls(pose, (posing.home, pose) if heavy else (pose,), places, misses)


def _posture(posing: Posing, wished: Places) -> Pose:
    """The posture that comes nearest to the places, of those that the joints can hold.

    First with the CoM in the middle; leaning out may help, and an upright trunk where one that
    leans is too heavy.
    """
    best: tuple[float, float, Pose] | None = None
    for firm_com, upright in ((True, 1.0), (False, 1.0), (True, 30.0), (True, 1000.0)):
        pose = posing.find(Wish(hands=wished, firm_com=firm_com, upright=upright))
        too_heavy = max(effort(posing.robot, pose.q).ratio - _STRENGTH, 0.0)
        miss = max(pose.misses.values())
        if too_heavy == 0.0 and miss <= _REACHABLE:
            return pose
        if best is None or (too_heavy, miss) < best[:2]:
            best = (too_heavy, miss, pose)
    assert best is not None
    return best[2]


def sample(posing: Posing, count: int, seed: int) -> list[Places]:
    """Places that both hands can reach at once, standing upright, clear of the body.

    Joints of the arms are drawn from the middle of their ranges; what brings a hand behind
    the body, across its middle, into the trunk or to the other hand is drawn again, and so
    is what the joints are too weak to hold, there or on the way.

    Raises:
        MotionError: hardly anything is within reach.
    """
    robot, anatomy = posing.robot, posing.anatomy
    random = np.random.default_rng(seed)
    arms = anatomy.both_arms()
    found: list[Places] = []
    for _ in range(400 * count):
        q = robot.q_nominal.copy()
        for arm in arms:
            joints = np.array(arm.joints)
            low, high = (np.clip(x[joints], -2.6, 2.6) for x in (robot.q_min, robot.q_max))
            share = random.uniform(_LEAST, _MOST, joints.size)
            q[7 + joints] = low + share * (high - low)
        places = {arm.hand: posing.place(arm.hand, q) for arm in arms}
        if _is_clear(posing, arms, places) and effort(robot, q).ratio < _STRENGTH:
            pose = posing.find(Wish(hands=places, firm_com=True), elsewhere=False)
            near = max(pose.misses.values()) <= _REACHABLE
            if near and hardest(robot, posing.home.q, pose.q).ratio < _STRENGTH:
                found.append(places)
            if len(found) == count:
                return found
    raise MotionError(f"reach: {robot.name}'s hands reach hardly anything in front of it")


def _is_clear(posing: Posing, arms: tuple[Arm, Arm], places: Places) -> bool:
    left, right = (places[arm.hand] for arm in arms)
    axis = posing.place(posing.robot.torso)
    length = arms[0].length
    for arm, place in zip(arms, (left, right), strict=True):
        outward = 1.0 if arm.side == "left" else -1.0
        shoulder = posing.place(arm.shoulder)
        if outward * place[1] < _ASIDE * length:
            return False
        if place[0] < shoulder[0] - _BEHIND * length:
            return False
        if np.hypot(*(place - axis)[:2]) < _CLEAR * length:
            return False
    return bool(np.linalg.norm(left - right) > _CLEAR * length)
