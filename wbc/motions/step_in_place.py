"""Step in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.motions.engine.context import MotionContext
from wbc.motions.engine.motion import Motion, Script, check_positive, parameter
from wbc.robot import Robot


@dataclass(frozen=True)
class StepInPlace(Motion):
    """Left, right, left, right, where it stands."""

    name: ClassVar[str] = "step-in-place"
    summary: ClassVar[str] = "step on the spot"

    steps: int = parameter(6, "how many")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "steps")

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.feet.step_in_place(self.steps)
        yield from context.until(lambda: not context.standing)
        yield from context.until(lambda: context.standing)
