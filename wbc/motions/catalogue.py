"""The motions that come with the library, by name."""

from __future__ import annotations

from wbc.errors import MotionError, did_you_mean
from wbc.motions.bow import Bow
from wbc.motions.jump import Jump
from wbc.motions.look import Look
from wbc.motions.motion import Motion
from wbc.motions.one_leg import OneLeg
from wbc.motions.reach import Reach
from wbc.motions.sine import Sine
from wbc.motions.squat import Squat
from wbc.motions.stepping import StepInPlace
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave

#: All of them; the command line, `show` and the live page take them from here.
CATALOGUE: tuple[type[Motion], ...] = (
    Sway,
    Squat,
    Wave,
    Reach,
    Look,
    OneLeg,
    Bow,
    StepInPlace,
    Jump,
    Sine,
)


def find(name: str) -> type[Motion]:
    """The motion of that name.

    Raises:
        MotionError: there is none; the text lists near names.
    """
    for motion in CATALOGUE:
        if motion.name == name:
            return motion
    raise MotionError(f"no motion '{name}'{did_you_mean(name, [m.name for m in CATALOGUE])}")
