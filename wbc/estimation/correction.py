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
        rows: the feet, as an index into arrays of all feet.
        residual: (k, 2, 3) workspace.
        both: (m, n + 1) workspace.
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
        self.rows: slice | list[int] = list(feet)
        if list(feet) == list(range(feet[0], feet[-1] + 1)):
            self.rows = slice(feet[0], feet[-1] + 1)  # a view is cheaper than a gather
        self.residual = np.empty((len(feet), 2, 3))
        self.both = np.empty((m, n + 1))
        self.H = np.zeros((m, n))
        self._C = np.zeros((m, m))
        for k, i in enumerate(feet):
            at, to = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            self.H[at, 6:9] = self.H[to, 0:3] = np.eye(3)
            self.H[at, place[i]] = self.H[to, turn[i]] = -np.eye(3)
            self._C[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = covariances[i]
        self._turn = np.zeros((m, m))
        blocks = np.arange(2 * len(feet))
        self._blocks = (blocks, slice(None), blocks, slice(None))
        self.N = self._C.copy()

    def turn_noise(self, R: np.ndarray) -> None:
        """Express the legs' noise in world axes: N = R C Rᵀ block by block."""
        k = len(self._turn) // 3
        self._turn.reshape(k, 3, k, 3)[self._blocks] = R
        np.matmul(self._turn @ self._C, self._turn.T, out=self.N)
