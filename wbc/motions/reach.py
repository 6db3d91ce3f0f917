"""Reach: both hands to positions, as far as the robot can, in balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.objective import PostureSolution
from wbc.motions.engine import (
    Motion,
    MotionContext,
    Script,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.motions.reaching.plan import ReachPlan, plan_reach
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

_FINAL_APPROACH = 0.4  # s
_XYZ = ("X", "Y", "Z")
_WHERE = "target x, y, z from the centre between the feet (m)"


@dataclass(frozen=True)
class Reach(Motion):
    """Move the hands to positions in the standing frame, midway between the soles, x forward.

    Without positions the motion goes through random ones that both hands can reach at once. A
    note tells what is out of reach and by how much, and the hand goes as near as it can.
    """

    name: ClassVar[str] = "reach"
    summary: ClassVar[str] = "move the hands to positions, given or random"

    left: tuple[float, ...] | None = parameter(None, f"left-hand {_WHERE}", names=_XYZ)
    right: tuple[float, ...] | None = parameter(None, f"right-hand {_WHERE}", names=_XYZ)
    random: int = parameter(4, "number of random positions when none is given")
    place_seed: int = parameter(0, "random seed")
    seconds: float = parameter(1.5, "minimum move time (s)")
    hold: float = parameter(0.5, "pause at each position, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "random", "seconds", "hold")
        upper_body = UpperBody.of(robot)
        given = self._given()
        if not given:
            upper_body.both_arms()
        for side, place in given.items():
            upper_body.arm(side)
            if len(place) != 3 or not np.isfinite(place).all():
                raise MotionError(f"reach: {side} = {place} must be three finite numbers, m")
        self._plan(robot)

    def _given(self) -> dict[str, tuple[float, ...]]:
        both = {"left": self.left, "right": self.right}
        return {side: place for side, place in both.items() if place is not None}

    @once_per_robot
    def _plan(self, robot: Robot) -> ReachPlan:
        return plan_reach(robot, self._given(), self.random, self.place_seed)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        plan = self._plan(context.robot)
        if plan.note:
            context.note(plan.note)
        for target in plan.targets:
            for side, text in target.out_of_reach.items():
                context.note(f"{side} hand: {text}")
            # The joints move the hands there, without singularities on the way; then tasks lead
            # the hands the last millimetres.
            yield from self._follow(context, target.path)
            for side, place in target.places.items():
                reachable = target.known_reachable or side not in target.out_of_reach
                context.hands.reach(side, place, _FINAL_APPROACH, is_target=reachable)
            yield from context.wait(_FINAL_APPROACH + self.hold)
        yield from self._follow(context, plan.return_path)
        yield from context.go_home(self.seconds)

    def _follow(self, context: MotionContext, path: Sequence[PostureSolution]) -> Script:
        context.hands.release(_FINAL_APPROACH)
        for posture in path:
            context.go_to_posture(posture, self.seconds)
            yield from context.until_arrived(context.posture)
