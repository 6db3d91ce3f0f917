"""The motion registry: all motions of the library, by name."""

from __future__ import annotations

from wbc.errors import MotionError, did_you_mean
from wbc.motions.brace import Brace
from wbc.motions.carry import Carry
from wbc.motions.demo import DEMO_MOTIONS, Demo
from wbc.motions.engine import Motion
from wbc.motions.hold_hand import HoldHand
from wbc.motions.keyframes import Keyframes
from wbc.motions.push_cart import PushCart

#: What the command line, the live page and the ROS 2 node offer.
MOTIONS: tuple[type[Motion], ...] = (
    *DEMO_MOTIONS,
    Brace,
    Carry,
    HoldHand,
    Keyframes,
    PushCart,
    Demo,
)


def find_motion(name: str) -> type[Motion]:
    """Return the motion type of that name.

    Raises:
        MotionError: there is none; the message lists similar names.
    """
    for motion in MOTIONS:
        if motion.name == name:
            return motion
    raise MotionError(f"no motion '{name}'{did_you_mean(name, [m.name for m in MOTIONS])}")
