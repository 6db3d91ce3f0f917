"""A stacked correction of the filter by several soles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


class Correction:
    """What is constant, and the workspace, of a filter's correction by one set of feet.

    Args:
        feet: their indices, ascending.
        n: size of the filter's error; it begins with rotation, velocity and position.
        place: where each foot's position error is in it.
        turn: where each foot's rotation error is.
        covariances: per foot of the robot (6, 6), of its pose as the encoders see it.

    Attributes:
        H: (m, n) of the measurement r = H ξ + noise.
        N: (m, m) covariance of the noise in world axes, after `turn_noise`.
        both: (m, n + 1) workspace for H P and, in the last column, r.
        places: per foot, view of the position's residual in `both`.
        turns: per foot, view of the rotation's residual.
        starts: where each foot's six rows begin.
    """

    def __init__(
        self,
        feet: tuple[int, ...],
        n: int,
        place: list[slice],
        turn: list[slice],
        covariances: Sequence[np.ndarray],
    ) -> None:
        m = 6 * len(feet)
        self.both = np.empty((m, n + 1))
        self.starts = np.arange(0, m, 6)
        self.places = [self.both[k : k + 3, n] for k in self.starts]
        self.turns = [self.both[k + 3 : k + 6, n] for k in self.starts]
        self.H = np.zeros((m, n))
        self._C = np.zeros((m, m))
        for k, i in enumerate(feet):
            at, to = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            self.H[at, 6:9] = self.H[to, 0:3] = np.eye(3)
            self.H[at, place[i]] = self.H[to, turn[i]] = -np.eye(3)
            self._C[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = covariances[i]
        self._turn = np.zeros((m, m))
        self._blocks = [self._turn[k : k + 3, k : k + 3] for k in range(0, m, 3)]
        self.N = self._C.copy()

    def turn_noise(self, R: np.ndarray) -> None:
        """Express the legs' noise in world axes: N = R C Rᵀ block by block."""
        for block in self._blocks:
            block[:] = R
        self._turn.dot(self._C).dot(self._turn.T, out=self.N)
