"""Show: every motion, one after the other, without a reset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.errors import MotionError
from wbc.motions.body import Body
from wbc.motions.motion import Motion, Script, once_per_robot, parameter
from wbc.motions.repertoire import REPERTOIRE
from wbc.robot import Robot


@dataclass(frozen=True)
class Show(Motion):
    """Everything that the robot can do; what it cannot do is left out, and said."""

    name: ClassVar[str] = "show"
    summary: ClassVar[str] = "every motion in a row, without a reset"

    pause: float = parameter(0.3, "between two motions, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        if not self.pause >= 0.0:
            raise MotionError(f"show: pause = {self.pause} s must not be negative")
        self._programme(robot)

    @once_per_robot
    def _programme(self, robot: Robot) -> tuple[list[Motion], list[str]]:
        """What is played, and what is said of the rest."""
        motions, notes = [], []
        for kind in REPERTOIRE:
            motion = kind.shown()
            try:
                motion.check(robot)
            except MotionError as error:
                notes.append(f"left out: {error}")
            else:
                motions.append(motion)
        return motions, notes

    def play(self, body: Body) -> Script:
        """See `Motion.play`."""
        motions, notes = self._programme(body.robot)
        for note in notes:
            body.note(note)
        for motion in motions:
            yield from motion.play(body)
            yield from body.go_home()
            yield from body.wait(self.pause)
