"""Joint positions and velocities from encoders, smoothed."""

from __future__ import annotations

import numpy as np


class JointFilter:
    """One stationary Kalman filter per joint over position and velocity.

    The model is `q̇ = v, v̇ = a + e` with the foreseen acceleration a, zero if nobody
    foresees one, and an error e that is white noise; measured are both q and v. With all
    joints alike, the stationary gain K is one 2×2 matrix, computed once, and an update is

        x⁺ = (1 − K) (A x + b a) + K z.

    Args:
        na: number of joints.
        dt: period, s.
        position: standard deviation of the encoders, rad.
        velocity: standard deviation of the velocity readings, rad/s.
        acceleration: standard deviation of e per period when nothing is foreseen, rad/s².
            Larger follows faster and smooths less; infinity passes readings through.
        surprise: that of e when an acceleration is foreseen, rad/s².

    Attributes:
        state: (2, na) filtered positions, rad, and velocities, rad/s.
        fresh: the next reading is taken as it is.
    """

    def __init__(
        self,
        na: int,
        dt: float,
        position: float,
        velocity: float,
        acceleration: float,
        surprise: float,
    ) -> None:
        self.state = np.zeros((2, na))
        self.fresh = True
        self._pass = _update_matrix(dt, np.eye(2))
        self._plain = _update_matrix(dt, stationary_gain(dt, position, velocity, acceleration))
        self._foreseen = self._plain
        if np.isfinite(acceleration):
            self._foreseen = _update_matrix(dt, stationary_gain(dt, position, velocity, surprise))

    def update_matrix(self, foreseen: bool) -> np.ndarray:
        """Return `U` (2, 5) of this period, `[q, v] ← U [q, v, a, reading of q, reading of v]`.

        Args:
            foreseen: whether somebody foresees the acceleration a; else a is to be zero.
        """
        if self.fresh:
            return self._pass
        return self._foreseen if foreseen else self._plain


def _update_matrix(dt: float, gain: np.ndarray) -> np.ndarray:
    """(2, 5) from [q, v, a, reading of q, reading of v] to the filtered [q, v]."""
    predict = np.array([[1.0, dt, dt * dt], [0.0, 1.0, dt]])
    return np.hstack(((np.eye(2) - gain) @ predict, gain))


def stationary_gain(dt: float, position: float, velocity: float, acceleration: float) -> np.ndarray:
    """(2, 2) gain of the filter in its steady state; the identity for no noise at all."""
    if not np.isfinite(acceleration) or (position == 0.0 and velocity == 0.0):
        return np.eye(2)
    A = np.array([[1.0, dt], [0.0, 1.0]])
    kick = acceleration * np.array([0.5 * dt * dt, dt])
    Q = np.outer(kick, kick)
    N = np.diag([max(position, 1e-9) ** 2, max(velocity, 1e-9) ** 2])
    P = N.copy()
    gain = np.eye(2)
    for _ in range(5000):
        P = A @ P @ A.T + Q
        new = np.linalg.solve((P + N).T, P.T).T
        P = P - new @ P
        if np.abs(new - gain).max() < 1e-13:
            break
        gain = new
    return gain
