"""Reach: both hands to places, as far as the robot can, in balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions.anatomy import Anatomy, Side
from wbc.motions.body import Body
from wbc.motions.motion import Motion, Script, once_per_robot, parameter, positive
from wbc.motions.nearest import nearest
from wbc.motions.posing import Posing
from wbc.motions.reachable import Draw, Drawn
from wbc.motions.ways import Ways
from wbc.motions.wish import Pose
from wbc.robot import Robot

_LAST = 0.4  # s
_XYZ = ("X", "Y", "Z")
_WHERE = "place forward and left of the soles' middle, and up, m"


@dataclass(frozen=True)
class Reach(Motion):
    """Hands to places in the standing frame: origin midway between the soles, x forward.

    Without places it goes through random ones that both hands can reach at once. What is out
    of reach is said, with the distance that is left, and the hand goes as near as it can.
    """

    name: ClassVar[str] = "reach"
    summary: ClassVar[str] = "lead the hands to places, given or random"

    left: tuple[float, ...] | None = parameter(None, f"of the left hand: {_WHERE}", names=_XYZ)
    right: tuple[float, ...] | None = parameter(None, f"of the right hand: {_WHERE}", names=_XYZ)
    random: int = parameter(4, "how many random places when none is given")
    draw: int = parameter(0, "seed of the random places")
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
        self._plan(robot)

    def _given(self) -> list[tuple[str, tuple[float, ...]]]:
        both = (("left", self.left), ("right", self.right))
        return [(side, place) for side, place in both if place is not None]

    @once_per_robot
    def _plan(self, robot: Robot) -> Itinerary:
        posing = Posing(robot)
        ways = Ways(posing)
        given = {posing.anatomy.arm(s).hand: np.array(p) for s, p in self._given()}
        draw = Draw(posing, self.draw)
        goals: list[Goal] = []
        before = posing.home
        for one in [Drawn(given, None)] if given else draw.places(self.random):
            goals.append(Goal.of(posing, ways, one, before))
            before = goals[-1].pose
        back = ways.between(before, posing.home)[:-1]
        return Itinerary(tuple(goals), back, "" if given else str(draw))

    def play(self, body: Body) -> Script:
        """See `Motion.play`."""
        plan = self._plan(body.robot)
        if plan.note:
            body.note(plan.note)
        for goal in plan.goals:
            for side, text in goal.misses.items():
                body.note(f"{side} hand: {text}")
            # The joints lead the hands there, without singularities on the way; then the hands
            # are led the last millimetres.
            yield from self._go(body, goal.way)
            for side, place in goal.places.items():
                body.reach(side, place, _LAST, counts=goal.counts or side not in goal.misses)
            yield from body.wait(_LAST + self.hold)
        yield from self._go(body, plan.back)
        yield from body.go_home(self.seconds)

    def _go(self, body: Body, way: Sequence[Pose]) -> Script:
        for hand in body.hands.values():
            hand.release(_LAST)
        for pose in way:
            body.take(pose, self.seconds)
            yield from body.arrive(body.posture)


@dataclass(frozen=True)
class Itinerary:
    """What is reached for one after the other.

    Attributes:
        goals: in this order.
        back: postures on the way from the last of them to standing.
        note: how the places were drawn.
    """

    goals: tuple[Goal, ...]
    back: tuple[Pose, ...]
    note: str


@dataclass(frozen=True)
class Goal:
    """Places for the hands, as near as the robot can.

    Attributes:
        pose: whole posture.
        way: postures one after the other, this one last: where the straight way is too heavy for
            the arms, it takes another.
        places: side -> (3,) where the hand goes, standing frame, m.
        misses: side -> what is said of a place that is out of reach.
        counts: whether even then they count as targets: they are known to be within reach.
    """

    pose: Pose
    way: Sequence[Pose]
    places: Mapping[Side, np.ndarray]
    misses: Mapping[Side, str]
    counts: bool

    @classmethod
    def of(cls, posing: Posing, ways: Ways, wished: Drawn, before: Pose) -> Goal:
        """The posture nearest to wished places, coming from another posture."""
        found = nearest(posing, wished)
        places: dict[Side, np.ndarray] = {}
        misses: dict[Side, str] = {}
        for arm in posing.anatomy.arms:
            if arm.hand in found.said:
                misses[arm.side] = found.said[arm.hand]
            if arm.hand in found.places:
                places[arm.side] = found.places[arm.hand]
        way = ways.between(before, found.pose)
        return cls(found.pose, way, places, misses, wished.q is not None)
