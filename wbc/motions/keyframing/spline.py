"""Cubic splines through points, at rest at both ends."""

from __future__ import annotations

import numpy as np


class Spline:
    """A twice continuously differentiable curve through points, at rest at both ends.

    Piecewise cubic with clamped ends (de Boor, A Practical Guide to Splines, 1978, ch. IV). It
    is constant before the first and after the last point.

    Args:
        times: (k,) strictly increasing times, s, k ≥ 2.
        points: (k, n) positions at these times.
    """

    def __init__(self, times: np.ndarray, points: np.ndarray) -> None:
        self.times = np.asarray(times, dtype=float)
        self._x = np.asarray(points, dtype=float)
        self._v = _velocities(self.times, self._x)

    def __call__(self, time: float) -> np.ndarray:
        """Return the position at a time, s; (n,)."""
        return self.derivatives(time)[0]

    def derivatives(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration at a time, s; (n,) each."""
        times = self.times
        if time <= times[0] or time >= times[-1]:
            still = np.zeros(self._x.shape[1])
            return self._x[0 if time <= times[0] else -1].copy(), still, still
        k = int(np.searchsorted(times, time, side="right")) - 1
        h = times[k + 1] - times[k]
        s = (time - times[k]) / h
        rise = self._x[k + 1] - self._x[k]
        a, b = h * self._v[k], h * self._v[k + 1]
        c2, c3 = 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise
        x = self._x[k] + s * (a + s * (c2 + s * c3))
        v = (a + s * (2.0 * c2 + 3.0 * s * c3)) / h
        return x, v, (2.0 * c2 + 6.0 * s * c3) / (h * h)


def _velocities(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the velocities (k, n) that make the accelerations continuous, zero at the ends."""
    k = t.size
    A, b = np.eye(k), np.zeros_like(x)
    for i in range(1, k - 1):
        before, after = t[i] - t[i - 1], t[i + 1] - t[i]
        A[i, i - 1 : i + 2] = (1.0 / before, 2.0 / before + 2.0 / after, 1.0 / after)
        b[i] = 3.0 * ((x[i] - x[i - 1]) / before**2 + (x[i + 1] - x[i]) / after**2)
    return np.linalg.solve(A, b)
