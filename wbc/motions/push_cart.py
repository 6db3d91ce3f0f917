"""Push a cart: a given force of both hands, walking behind it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

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
from wbc.robot.upper_body import SIDES

_POSTURE_TIME = 1.5  # s
_LOAD_TIME = 1.0  # s within which the force comes and goes


@dataclass(frozen=True)
class PushCart(Motion):
    """Put both hands on a cart and push it with a given force, walking behind it.

    The hands are contacts whose normal forces are given: the arms exert them, and the balance
    leans against them. Where the cart goes is left to the cart; the hands stay with it.
    """

    name: ClassVar[str] = "push-cart"
    summary: ClassVar[str] = "push a cart with a given force, walking behind it"

    force: float = parameter(20.0, "force of both hands together, N")
    distance: float = parameter(0.3, "distance of the cart from the middle of the soles, m")
    walk: float = parameter(0.15, "velocity of walking behind it, m/s")
    seconds: float = parameter(6.0, "time of walking, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "force", "distance", "walk", "seconds")
        most = sum(plan.max_force for plan in self._plans(robot))
        if self.force > most:
            raise MotionError(
                f"push-cart: {self.force:g} N is more than the arms of {robot.name} exert there: "
                f"{most:.0f} N"
            )

    @once_per_robot
    def _plans(self, robot: Robot) -> tuple[BracePlan, ...]:
        return tuple(plan_brace(robot, side, 0.0, self.distance) for side in SIDES)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        left, right = self._plans(context.robot)
        posture = left.path[-1].q[7:].copy()
        joints = list(context.upper_body.arm("right").joints)
        posture[joints] = right.path[-1].q[7:][joints]
        context.posture.move_to(posture, _POSTURE_TIME)
        yield from context.until_arrived(context.posture)
        hands = context.hand_contacts
        for side, plan in zip(SIDES, (left, right), strict=True):
            yield from hands.touch(side, plan.normal, point=plan.point)
            hands.let_move(side)
        share = 0.5 * self.force
        yield from hands.load_all(share, share, _LOAD_TIME)
        context.note(f"pushes with {self.force:g} N")
        context.feet.walk((self.walk, 0.0, 0.0))
        yield from context.wait(self.seconds)
        context.feet.walk((0.0, 0.0, 0.0))
        yield from context.until(lambda: context.standing)
        yield from hands.load_all(0.0, 0.0, _LOAD_TIME)
        for side in SIDES:
            yield from hands.release(side, 0.3)
        context.hands.release(0.5)
        context.posture.move_to(context.posture.home, _POSTURE_TIME)
        yield from context.until_arrived(context.posture)
