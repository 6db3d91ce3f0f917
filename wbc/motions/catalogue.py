"""All motions that come with the library, by name."""

from __future__ import annotations

from wbc.errors import MotionError, did_you_mean
from wbc.motions.keyframes import Keyframes
from wbc.motions.motion import Motion
from wbc.motions.repertoire import REPERTOIRE
from wbc.motions.show import Show

#: The command line and the live page take them from here.
CATALOGUE: tuple[type[Motion], ...] = (*REPERTOIRE, Keyframes, Show)


def find(name: str) -> type[Motion]:
    """The motion of that name.

    Raises:
        MotionError: there is none; the text lists near names.
    """
    for motion in CATALOGUE:
        if motion.name == name:
            return motion
    raise MotionError(f"no motion '{name}'{did_you_mean(name, [m.name for m in CATALOGUE])}")
