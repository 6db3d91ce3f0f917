"""Joint positions and velocities from encoders, smoothed."""

from __future__ import annotations

import numpy as np


class JointFilter:
    """One stationary Kalman filter per joint over position and velocity.

    The model is `q̇ = v, v̇ = a + e` with the foreseen acceleration a, zero if nobody
    foresees one, and an error e that is white noise; measured are both q and v. With all
    joints alike, the stationary gain is one 2×2 matrix, found once.

    Args:
        na: number of joints.
        dt: period, s.
        position: standard deviation of the encoders, rad.
        velocity: standard deviation of the velocity readings, rad/s.
        acceleration: standard deviation of e per period when nothing is foreseen, rad/s².
            Larger follows faster and smooths less; infinity passes readings through.
        surprise: that of e when an acceleration is foreseen, rad/s².
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
        self._dt = dt
        self._x = np.zeros((2, na))
        self._prediction = np.zeros((2, na))
        self._gain = stationary_gain(dt, position, velocity, acceleration)
        self._foreseen_gain = stationary_gain(dt, position, velocity, surprise)
        self._passes = not np.isfinite(acceleration)
        self._fresh = True

    def reset(self) -> None:
        """Forget: the next reading is taken as it is."""
        self._fresh = True

    def update(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        acceleration: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Filtered (position, velocity); views that the next update overwrites.

        Args:
            position: (na,) encoders, rad.
            velocity: (na,) rad/s.
            acceleration: (na,) foreseen over the period that ends now, rad/s²; none: zero.
        """
        x = self._x
        if self._fresh or self._passes:
            x[0] = position
            x[1] = velocity
            self._fresh = False
            return x[0], x[1]
        gain = self._gain
        if acceleration is not None:
            gain = self._foreseen_gain
            x[1] += self._dt * acceleration
        x[0] += self._dt * x[1]
        innovation = self._prediction
        np.subtract(position, x[0], out=innovation[0])
        np.subtract(velocity, x[1], out=innovation[1])
        x += gain @ innovation
        return x[0], x[1]


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
