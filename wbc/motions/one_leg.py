"""One leg: stand on one foot, withstand a light push, stand on both again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions.engine import Motion, MotionContext, Script, check_positive, parameter
from wbc.robot import Robot
from wbc.robot.upper_body import SIDES, Side

_MAX_HEIGHT = 30.0  # % of the leg


@dataclass(frozen=True)
class OneLeg(Motion):
    """Stand on one leg: shift the weight, lift the other foot, hold, put it down.

    In the middle of the hold a simulated robot gets a push on the torso.
    """

    name: ClassVar[str] = "one-leg"
    summary: ClassVar[str] = "stand on one leg, be pushed lightly, stand on both again"

    leg: str = parameter("both", "leg to stand on", choices=("left", "right", "both"))
    hold: float = parameter(5.0, "time on one leg, s")
    height: float = parameter(8.0, "height of the lifted sole, % of the leg's length")
    impulse: float = parameter(
        0.05, "impulse of the push in mid-hold, only in simulation, N·s per kg"
    )
    towards: float = parameter(90.0, "direction of the push: 0 forward, 90 left, °")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "hold", "height")
        if self.height > _MAX_HEIGHT:
            raise MotionError(
                f"one-leg: height = {self.height} % is beyond {_MAX_HEIGHT:g} % of the leg"
            )

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        support_sides: Sequence[Side] = SIDES if self.leg == "both" else (self._side(),)
        angle = math.radians(self.towards)
        push = self.impulse * np.array([math.cos(angle), math.sin(angle), 0.0])
        for support in support_sides:
            lifted: Side = "right" if support == "left" else "left"
            yield from context.feet.lift(lifted, 0.01 * self.height * context.robot.leg_length)
            yield from context.wait(0.5 * self.hold)
            context.request_push(push)
            yield from context.wait(0.5 * self.hold)
            yield from context.feet.put_down()

    def _side(self) -> Side:
        return "left" if self.leg == "left" else "right"
