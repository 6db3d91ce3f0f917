"""Step in place: steps on the spot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.motions.engine import Motion, MotionContext, Script, check_positive, parameter
from wbc.robot import Robot


@dataclass(frozen=True)
class StepInPlace(Motion):
    """Step with the left and the right foot in turn, onto the places where they stand."""

    name: ClassVar[str] = "step-in-place"
    summary: ClassVar[str] = "step on the spot"

    steps: int = parameter(6, "number of steps")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "steps")

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.feet.step_in_place(self.steps)
        yield from context.until(lambda: not context.standing)
        yield from context.until(lambda: context.standing)
