"""The objective of a standing posture, and the posture that was found for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


def _zeros() -> np.ndarray:
    return np.zeros(3)


@dataclass(frozen=True)
class PostureObjective:
    """Targets for a posture on both feet, in the standing frame.

    The standing frame has its origin on the ground midway between the soles, x forward, z up.

    Attributes:
        com: (3,) offset of the CoM from its place when standing, m.
        torso: (3,) rotation vector of the upper trunk from upright, rad.
        pelvis: (3,) likewise of the root link, rad.
        hands: frame name -> (3,) position of its origin, m.
        strict_trunk: whether the trunk must be as stated, instead of helping the hands.
        strict_com: likewise the CoM.
        trunk_weight: how much it costs to turn a trunk that is not strict; 1 is cheap.
        fixed_joints: indices into (na,) of joints that stay as they are at the start.
        near: (nq,) posture to be near in all that is left open; the nominal one if None.
    """

    com: np.ndarray = field(default_factory=_zeros)
    torso: np.ndarray = field(default_factory=_zeros)
    pelvis: np.ndarray = field(default_factory=_zeros)
    hands: Mapping[str, np.ndarray] = field(default_factory=dict)
    strict_trunk: bool = False
    strict_com: bool = False
    trunk_weight: float = 1.0
    fixed_joints: tuple[int, ...] = ()
    near: np.ndarray | None = None


@dataclass(frozen=True)
class PostureSolution:
    """A posture on both feet that was found for an objective.

    Attributes:
        q: (nq,) posture in the standing frame.
        com: (3,) offset of the CoM from its place when standing, m.
        torso: (3,) rotation vector of the upper trunk from upright, rad.
        pelvis: (3,) likewise of the root link, rad.
        hand_errors: frame name -> distance to its target, m.
        com_error: distance of the CoM to its target, m.
        at_limit: indices into (na,) of joints at their limit.
    """

    q: np.ndarray
    com: np.ndarray
    torso: np.ndarray
    pelvis: np.ndarray
    hand_errors: Mapping[str, float]
    com_error: float
    at_limit: tuple[int, ...]

    @property
    def hand_error(self) -> float:
        """The largest of `hand_errors`, m; 0 without hands."""
        return max(self.hand_errors.values(), default=0.0)

    def __repr__(self) -> str:
        x, y, z = (1e3 * self.com).tolist()
        hands = "".join(f", {n} {1e3 * e:.1f} mm off" for n, e in self.hand_errors.items())
        limits = f", {len(self.at_limit)} joints at their limit" if self.at_limit else ""
        return f"PostureSolution(CoM ({x:+.0f}, {y:+.0f}, {z:+.0f}) mm{hands}{limits})"
