"""Reach: both hands to places, as far as the robot can, in balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureSolution
from wbc.ik.posture_ik import PostureIK
from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion, Script, check_positive, once_per_robot, parameter
from wbc.motions.reaching.arm_paths import ArmPaths
from wbc.motions.reaching.closest_posture import closest_posture
from wbc.motions.reaching.place_sampler import PlaceSampler, SampledPlaces
from wbc.robot import Robot
from wbc.robot.upper_body import Side, UpperBody

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
        check_positive(self, "random", "seconds", "hold")
        upper_body = UpperBody.of(robot)
        if self.left is None and self.right is None:
            upper_body.both_arms()
        for side, place in self._given():
            upper_body.arm(side)
            if len(place) != 3 or not np.isfinite(place).all():
                raise MotionError(f"reach: {side} = {place} must be three finite numbers, m")
        self._plan(robot)

    def _given(self) -> list[tuple[str, tuple[float, ...]]]:
        both = (("left", self.left), ("right", self.right))
        return [(side, place) for side, place in both if place is not None]

    @once_per_robot
    def _plan(self, robot: Robot) -> ReachPlan:
        ik = PostureIK(robot)
        ways = ArmPaths(ik)
        given = {ik.upper_body.arm(s).hand: np.array(p) for s, p in self._given()}
        draw = PlaceSampler(ik, self.draw)
        goals: list[ReachTarget] = []
        before = ik.home
        for one in [SampledPlaces(given, None)] if given else draw.places(self.random):
            goals.append(ReachTarget.of(ik, ways, one, before))
            before = goals[-1].pose
        back = ways.between(before, ik.home)[:-1]
        return ReachPlan(tuple(goals), back, "" if given else str(draw))

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        plan = self._plan(context.robot)
        if plan.note:
            context.note(plan.note)
        for goal in plan.goals:
            for side, text in goal.misses.items():
                context.note(f"{side} hand: {text}")
            # The joints lead the hands there, without singularities on the way; then the hands
            # are led the last millimetres.
            yield from self._go(context, goal.way)
            for side, place in goal.places.items():
                context.hands.reach(
                    side, place, _LAST, is_target=goal.counts or side not in goal.misses
                )
            yield from context.wait(_LAST + self.hold)
        yield from self._go(context, plan.back)
        yield from context.go_home(self.seconds)

    def _go(self, context: MotionContext, way: Sequence[PostureSolution]) -> Script:
        context.hands.release(_LAST)
        for pose in way:
            context.go_to_posture(pose, self.seconds)
            yield from context.until_arrived(context.posture)


@dataclass(frozen=True)
class ReachPlan:
    """What is reached for one after the other.

    Attributes:
        goals: in this order.
        back: postures on the way from the last of them to standing.
        note: how the places were drawn.
    """

    goals: tuple[ReachTarget, ...]
    back: tuple[PostureSolution, ...]
    note: str


@dataclass(frozen=True)
class ReachTarget:
    """Places for the hands, as near as the robot can.

    Attributes:
        pose: whole posture.
        way: postures one after the other, this one last: where the straight way is too heavy for
            the arms, it takes another.
        places: side -> (3,) where the hand goes, standing frame, m.
        misses: side -> what is said of a place that is out of reach.
        counts: whether even then they count as targets: they are known to be within reach.
    """

    pose: PostureSolution
    way: Sequence[PostureSolution]
    places: Mapping[Side, np.ndarray]
    misses: Mapping[Side, str]
    counts: bool

    @classmethod
    def of(
        cls, ik: PostureIK, ways: ArmPaths, wished: SampledPlaces, before: PostureSolution
    ) -> ReachTarget:
        """The posture nearest to wished places, coming from another posture."""
        found = closest_posture(ik, wished)
        places: dict[Side, np.ndarray] = {}
        misses: dict[Side, str] = {}
        for arm in ik.upper_body.arms:
            if arm.hand in found.said:
                misses[arm.side] = found.said[arm.hand]
            if arm.hand in found.places:
                places[arm.side] = found.places[arm.hand]
        way = ways.between(before, found.pose)
        return cls(found.pose, way, places, misses, wished.q is not None)
