"""What a player promises at an instant, relative to the soles: motions are judged by it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Target:
    """A place where a frame of the robot is to be.

    Attributes:
        frame: name.
        place: (3,) m, in the standing frame (origin on the ground midway between the soles,
            x forward).
        number: counts the targets of this frame; a new number is a new target.
    """

    frame: str
    place: np.ndarray
    number: int


@dataclass(frozen=True, slots=True)
class MotionReference:
    """Where the CoM and other things are wanted, so that anybody can compare with the truth.

    Attributes:
        lean: the origin for `com` is on the ground between the soles' centres, at this share
            of the way from the right to the left one; its x axis is their mean heading.
        com: (3,) CoM wanted, m; None while walking, whose plan is one of the DCM.
        targets: places that are held right now.
    """

    lean: float
    com: np.ndarray | None
    targets: tuple[Target, ...] = ()
