"""A motion that has been checked elsewhere, and that cannot bring the loop down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.errors import MotionError
from wbc.motions import Body, Motion, Script


@dataclass(frozen=True)
class Cleared(Motion):
    """Plays another motion without checking it again: a check may take a second, a tick may not.

    Args:
        motion: the other one.
    """

    name: ClassVar[str] = "cleared"
    summary: ClassVar[str] = "a motion that has been checked"

    motion: Motion

    def play(self, body: Body) -> Script:
        """See `Motion.play`; what the robot turns out unable to do is noted and left off."""
        try:
            yield from self.motion.play(body)
        except MotionError as error:
            body.note(str(error))
