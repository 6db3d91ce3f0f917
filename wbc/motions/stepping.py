"""Step in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.motions.body import Body
from wbc.motions.motion import Motion, Script, parameter, positive
from wbc.robot import Robot


@dataclass(frozen=True)
class StepInPlace(Motion):
    """Left, right, left, right, where it stands."""

    name: ClassVar[str] = "step-in-place"
    summary: ClassVar[str] = "step on the spot"

    steps: int = parameter(6, "how many")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        positive(self, "steps")

    def play(self, body: Body) -> Script:
        """See `Motion.play`."""
        body.step_in_place(self.steps)
        yield from body.until(lambda: not body.standing)
        yield from body.until(lambda: body.standing)
