"""What a standing posture should be like, and the posture that was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


def _zeros() -> np.ndarray:
    return np.zeros(3)


@dataclass(frozen=True)
class PostureObjective:
    """What a posture should be like; in the standing frame.

    Attributes:
        com: (3,) offset of the CoM from standing, m.
        torso: (3,) rotation vector of the upper trunk, rad.
        pelvis: (3,) likewise of the root link.
        hands: frame -> (3,) place of its origin, m.
        firm: whether the trunk is to be as said, instead of helping the hands.
        firm_com: likewise the CoM.
        upright: how dear it is to turn the trunk for a hand's sake; 1 is cheap.
        kept: indices into (na,) of joints that stay as they are at the start.
        near: (nq,) posture that it is to be like in all that is open; the nominal one if None.
    """

    com: np.ndarray = field(default_factory=_zeros)
    torso: np.ndarray = field(default_factory=_zeros)
    pelvis: np.ndarray = field(default_factory=_zeros)
    hands: Mapping[str, np.ndarray] = field(default_factory=dict)
    firm: bool = False
    firm_com: bool = False
    upright: float = 1.0
    kept: tuple[int, ...] = ()
    near: np.ndarray | None = None


@dataclass(frozen=True)
class PostureSolution:
    """A posture that was found.

    Attributes:
        q: (nq,) in the standing frame.
        com: (3,) offset of the CoM from standing, m.
        torso: (3,) rotation vector of the upper trunk, rad.
        pelvis: (3,) of the root link.
        misses: frame -> distance to its wished place, m.
        com_miss: distance of the CoM to its wished place, m.
        at_limit: indices into (na,) of joints at their limit.
    """

    q: np.ndarray
    com: np.ndarray
    torso: np.ndarray
    pelvis: np.ndarray
    misses: Mapping[str, float]
    com_miss: float
    at_limit: tuple[int, ...]

    @property
    def miss(self) -> float:
        """The largest of `misses`, m; 0 without hands."""
        return max(self.misses.values(), default=0.0)
