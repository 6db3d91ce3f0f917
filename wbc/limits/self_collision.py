"""Distances between the bodies of a robot as a limit."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.limits.distance import DistanceLimit
from wbc.limits.near_pairs import NearPairs
from wbc.robot import RobotModel
from wbc.robot.self_collision import SelfCollision

_SHARE_AT_REST = 0.5  # of the nominal distance, which a margin may take


class SelfCollisionLimit(DistanceLimit):
    """Keeps the bodies of a robot apart, see `DistanceLimit`.

    Pairs that are nearer in the nominal posture than the margin get half of that distance for a
    margin.

    Args:
        robot: the robot.
        margin: distance that is kept, m.
        detection: pairs farther apart than that are left aside, m.
        size: largest number of rows, those of the nearest pairs first.
        gain: how fast bodies may approach each other, 1/s; see `BarrierLimit`.
        recovery, priority, weight: see `BarrierLimit`.

    Attributes:
        pairs: shapes and pairs; `pairs.report()` tells what was chosen.

    Raises:
        LimitError: a margin that is negative or not below the detection distance, no pair to
            watch, or see `BarrierLimit`.
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        margin: float = 0.01,
        detection: float = 0.06,
        size: int = 60,
        gain: float = 20.0,
        recovery: float = 0.1,
        priority: int = 0,
        weight: float = 1.0,
        name: str = "self-collision limit",
    ) -> None:
        self.pairs = found = SelfCollision.of(robot)
        count = len(found.pairs)
        if not count:
            raise LimitError(f"{name}: there is no pair to watch ({found.report()})")
        room = _SHARE_AT_REST * np.maximum(found.nominal_distance, 0.0)
        super().__init__(
            name,
            robot,
            NearPairs(found.shapes, found.pairs, found.geometry),
            [found.pair_name(k) for k in range(count)],
            np.full(count, margin) if margin >= detection else np.minimum(margin, room),
            detection,
            size,
            gain,
            recovery,
            priority,
            weight,
        )
        self.margin = margin
