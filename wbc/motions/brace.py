"""Brace: a hand on a wall is a contact like a foot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions.bracing.plan import BracePlan, plan_brace
from wbc.motions.engine import (
    Motion,
    MotionContext,
    Script,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.robot import Robot

_LEAST_FORCE = 0.2  # of the largest: what keeps the hand on the wall
_LEAN_TIME = 2.0  # s


@dataclass(frozen=True)
class Brace(Motion):
    """Put a hand on a wall, press, hold, and take it off again.

    The hand feels its way to the wall by the torques of the arm. From then on the balance counts on
    the force that the arm can bear there: the robot takes larger pushes without a step, and its
    centre of mass may leave the soles. `lean` moves it, towards the wall.
    """

    name: ClassVar[str] = "brace"
    summary: ClassVar[str] = "put a hand on a wall, and lean on it"

    hand: str = parameter("left", "hand that presses", choices=("left", "right"))
    distance: float = parameter(0.3, "distance of the wall from the middle of the soles, m")
    towards: float = parameter(0.0, "direction of the wall: 0 forward, 90 left, °")
    lean: float = parameter(0.0, "how far the centre of mass goes towards the wall, m")
    hold: float = parameter(3.0, "time of pressing, s")
    impulse: float = parameter(
        0.0, "impulse of a push towards the wall in mid-hold, only in simulation, N·s per kg"
    )

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "distance", "hold")
        if self.lean < 0.0:
            raise MotionError(f"brace: lean = {self.lean} m must not be negative")
        self._plan(robot)

    @once_per_robot
    def _plan(self, robot: Robot) -> BracePlan:
        return plan_brace(robot, self.hand, math.radians(self.towards), self.distance)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        plan = self._plan(context.robot)
        for posture in plan.path:
            context.posture.move_to(posture.q[7:], 1.5)
            yield from context.until_arrived(context.posture)
        hands = context.hand_contacts
        yield from hands.touch(self.hand, plan.normal, point=plan.point)
        yield from hands.load(self.hand, _LEAST_FORCE * plan.max_force, plan.max_force)
        context.note(f"{self.hand} hand on the wall, up to {plan.max_force:.0f} N")
        if self.lean:
            context.com.move_to(-self.lean * plan.normal, _LEAN_TIME)
            yield from context.until_arrived(context.com)
        yield from context.wait(0.5 * self.hold)
        if self.impulse:
            context.request_push(-self.impulse * np.asarray(plan.normal))
        yield from context.wait(0.5 * self.hold)
        if self.lean:
            context.com.move_to(0.0, _LEAN_TIME)
            yield from context.until_arrived(context.com)
        yield from hands.release(self.hand)
        context.hands.release(0.5)
        for posture in plan.return_path:
            context.posture.move_to(posture.q[7:], 1.5)
            yield from context.until_arrived(context.posture)
