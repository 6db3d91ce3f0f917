"""Write your own motion: a dataclass whose `play` sets references and waits.

Each `yield from` lets time pass; meanwhile the references move smoothly to their targets, so that
no torque jumps. The motion can be interrupted at any tick without further code.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

import wbc
from wbc.motions import Motion, MotionContext, Script, parameter
from wbc.trials import run_motions


@dataclass(frozen=True)
class KickTheAir(Motion):
    """Stand on one leg and swing the other forward and back, arms held up."""

    name: ClassVar[str] = "kick"
    summary: ClassVar[str] = "kick the air"

    kicks: int = parameter(3, "number of kicks")
    reach: float = parameter(0.12, "of the foot to the front and to the back, m")

    def play(self, context: MotionContext) -> Script:
        """Return the script."""
        for arm in context.upper_body.arms:
            side = 1.0 if arm.side == "left" else -1.0
            context.hands.reach(arm.side, (0.3, side * 0.4, 1.2), duration=1.5)
        yield from context.feet.lift("right", height=0.08)
        for _ in range(self.kicks):
            context.turn_trunk((0.0, -0.08, 0.0), duration=0.6)
            yield from context.feet.move_foot(forward=self.reach, up=0.1, duration=0.6)
            context.turn_trunk((0.0, 0.08, 0.0), duration=0.6)
            yield from context.feet.move_foot(forward=-self.reach, up=0.1, duration=0.6)
        yield from context.feet.put_down()
        context.com.follow(lambda t: np.array([0.0, 0.02 * np.sin(6.0 * t), 0.0]))  # a small sway
        yield from context.wait(1.5)
        context.note(f"{self.kicks} kicks")


if __name__ == "__main__":
    robot = wbc.load("simple_humanoid")
    print(run_motions(robot, [KickTheAir(kicks=2)], seed=1).table())
