"""Demo: every motion, one after the other, without a reset in between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.errors import MotionError
from wbc.motions.bow import Bow
from wbc.motions.engine import Motion, MotionContext, Script, once_per_robot, parameter
from wbc.motions.jump import Jump
from wbc.motions.look import Look
from wbc.motions.one_leg import OneLeg
from wbc.motions.reach import Reach
from wbc.motions.sine import Sine
from wbc.motions.squat import Squat
from wbc.motions.step_in_place import StepInPlace
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave
from wbc.robot import Robot

#: The motions that the demo plays, in this order.
DEMO_MOTIONS: tuple[type[Motion], ...] = (
    Sway,
    Squat,
    Wave,
    Reach,
    Look,
    OneLeg,
    Bow,
    StepInPlace,
    Sine,
    Jump,
)


@dataclass(frozen=True)
class Demo(Motion):
    """Play every motion that the robot can do; the notes of the report list the others."""

    name: ClassVar[str] = "demo"
    summary: ClassVar[str] = "play every motion in a row, without a reset"

    pause: float = parameter(0.3, "pause between two motions, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        if not self.pause >= 0.0:
            raise MotionError(f"demo: pause = {self.pause} s must not be negative")
        self._program(robot)

    @once_per_robot
    def _program(self, robot: Robot) -> tuple[list[Motion], list[str]]:
        """Return the motions that the robot can do, and a note for each of the others."""
        motions, notes = [], []
        for motion_type in DEMO_MOTIONS:
            motion = motion_type.for_demo()
            try:
                motion.check(robot)
            except MotionError as error:
                notes.append(f"left out: {error}")
            else:
                motions.append(motion)
        return motions, notes

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        motions, notes = self._program(context.robot)
        for note in notes:
            context.note(note)
        for motion in motions:
            yield from motion.play(context)
            yield from context.go_home()
            yield from context.wait(self.pause)
