"""The references of a motion player at a tick, which evaluators compare with the true state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class FrameTarget:
    """A position that a frame of the robot has been brought to and is held at.

    Attributes:
        frame: name of the frame.
        place: (3,) position in the standing frame (origin on the ground midway between the
            soles, x forward), m.
        number: counts the targets of this frame; a new number is a new target.
    """

    frame: str
    place: np.ndarray
    number: int


@dataclass(frozen=True, slots=True)
class MotionReference:
    """References of CoM and frames at one tick, relative to the soles.

    Attributes:
        weight_shift: the origin for `com` is on the ground between the soles' centres, at this
            share of the way from the right to the left one; its x axis is their mean heading.
        com: (3,) reference of the CoM, m; None while walking, whose plan is one of the DCM.
        targets: the frames that are held at a position now.
    """

    weight_shift: float
    com: np.ndarray | None
    targets: tuple[FrameTarget, ...] = ()
