"""The motions that are each a thing of its own: the show plays all of them."""

from __future__ import annotations

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

#: In the order of the show.
REPERTOIRE: tuple[type[Motion], ...] = (
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
