"""Heights over time: push-off, landing, crouch, and the soles in flight."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients

#: Height, m, velocity, m/s, and acceleration, m/s².
HeightState = tuple[float, float, float]


class HeightProfile:
    """A height over time whose acceleration is piecewise linear.

    Args:
        start: height at time 0, m.
        velocity: velocity at time 0, m/s.
        times: (k,) times of the knots, ascending from 0, s.
        accelerations: (k,) accelerations at the knots, m/s².
    """

    def __init__(
        self, start: float, velocity: float, times: np.ndarray, accelerations: np.ndarray
    ) -> None:
        self._t, self._a = np.asarray(times, dtype=float), np.asarray(accelerations, dtype=float)
        t, a = self._t.tolist(), self._a.tolist()
        z, v, jerk = [float(start)], [float(velocity)], []
        for k in range(len(t) - 1):
            h = t[k + 1] - t[k]
            j = (a[k + 1] - a[k]) / h
            z.append(z[k] + h * (v[k] + h * (0.5 * a[k] + h * j / 6.0)))
            v.append(v[k] + h * (a[k] + 0.5 * h * j))
            jerk.append(j)
        self._z, self._v, self._jerk = np.array(z), np.array(v), np.array(jerk)

    @property
    def duration(self) -> float:
        """Time of the last knot, s."""
        return float(self._t[-1])

    @property
    def end(self) -> HeightState:
        """Height, velocity and acceleration at the end."""
        return float(self._z[-1]), float(self._v[-1]), float(self._a[-1])

    def at(self, time: float) -> HeightState:
        """Position, velocity and acceleration; held within the duration."""
        z, v, a = self.sample(np.array([time]))
        return float(z[0]), float(v[0]), float(a[0])

    def sample(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return heights, velocities and accelerations (k,) at times (k,), s."""
        t = np.clip(times, 0.0, self._t[-1])
        k = np.clip(np.searchsorted(self._t, t, side="right") - 1, 0, len(self._t) - 2)
        h, a, j, v = t - self._t[k], self._a[k], self._jerk[k], self._v[k]
        return (
            self._z[k] + h * (v + h * (0.5 * a + h * j / 6.0)),
            v + h * (a + 0.5 * h * j),
            a + h * j,
        )


_RAMP_UP = 0.3  # share of a stroke in which its acceleration reaches the plateau
_RAMP_DOWN = 0.2  # share in which it goes from the plateau to its final value


def stroke(start: float, velocity: float, end: HeightState, begin: float = 0.0) -> HeightProfile:
    """Return the profile between two heights and velocities with one plateau of acceleration.

    The acceleration goes linearly from `begin` to the plateau and from there to its final value.
    Duration T and plateau a follow from the two ends: with A, B, C the first and second
    integrals of the unit shapes of plateau, start a₀ and end a₁,

        Δv = T (a A₁ + a₀ B₁ + a₁ C₁),   Δz = v₀ T + T² (a A₂ + a₀ B₂ + a₁ C₂).

    Args:
        start: height at the start, m.
        velocity: velocity at the start, m/s.
        end: height, velocity and acceleration at the end.
        begin: acceleration at the start, m/s².
    """
    height, speed, final = end
    first = (0.5 * _RAMP_UP, 0.5 * _RAMP_UP - _RAMP_UP**2 / 6.0)
    last = (0.5 * _RAMP_DOWN, _RAMP_DOWN**2 / 6.0)
    plateau = (1.0 - first[0] - last[0], 0.5 - first[1] - last[1])
    rest = [begin * f + final * e for f, e in zip(first, last, strict=True)]
    ratio = plateau[1] / plateau[0]
    square = rest[1] - rest[0] * ratio
    linear = velocity + (speed - velocity) * ratio
    duration = _least_positive_root(square, linear, start - height)
    a = ((speed - velocity) / duration - rest[0]) / plateau[0]
    knots = np.array([0.0, _RAMP_UP, 1.0 - _RAMP_DOWN, 1.0])
    return HeightProfile(start, velocity, duration * knots, np.array([begin, a, a, final]))


def _least_positive_root(a: float, b: float, c: float) -> float:
    """Return the least positive root of a x² + b x + c."""
    if abs(a) < 1e-12 * abs(b):
        return -c / b
    # The sum without cancellation, then the other root by Vieta.
    half = -0.5 * (b + math.copysign(math.sqrt(b * b - 4.0 * a * c), b))
    return min(x for x in (half / a, c / half) if x > 0.0)


@dataclass(frozen=True, slots=True)
class MinimumJerk:
    """A coordinate from rest to rest with least jerk; see `wbc.geometry.quintic`.

    Attributes:
        start: value at time 0.
        end: value at time `duration`.
        duration: s.
    """

    start: float
    end: float
    duration: float

    def at(self, time: float) -> HeightState:
        """Position, velocity and acceleration; held within the duration."""
        T = self.duration
        c = quintic_coefficients(self.start, 0.0, 0.0, self.end)
        x, v, a = evaluate_quintic(c, min(max(time / T, 0.0), 1.0))
        return x, v / T, a / T**2


@dataclass(frozen=True, slots=True)
class HopProfile:
    """Height of the soles in flight: `64 c x³ (1 − x)³ + v T x³ (1 − x)`, x = t / T.

    They leave the ground at rest and without acceleration, as the push-off ends, are c high in
    the middle, and come down with v at T; after that they continue down at v.

    Attributes:
        duration: T, s.
        clearance: height in the middle of the flight c, m.
        touchdown: downward velocity v at the end, m/s.
    """

    duration: float
    clearance: float
    touchdown: float

    def at(self, time: float) -> HeightState:
        """Height, velocity and acceleration at a time since take-off, s."""
        z, v, a = self.sample(np.array([time]))
        return float(z[0]), float(v[0]), float(a[0])

    def sample(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return heights, velocities and accelerations (k,) at times (k,), s."""
        T, c, w = self.duration, 64.0 * self.clearance, self.touchdown * self.duration
        x = np.clip(times / T, 0.0, 1.0)
        late = np.maximum(times - T, 0.0)
        y = x * (1.0 - x)
        flying = late == 0.0
        return (
            c * y**3 + w * x**3 * (1.0 - x) - self.touchdown * late,
            (3.0 * c * y * y * (1.0 - 2.0 * x) + w * x * x * (3.0 - 4.0 * x)) / T,
            flying
            * (6.0 * c * y * ((1.0 - 2.0 * x) ** 2 - y) + 6.0 * w * x * (1.0 - 2.0 * x))
            / T**2,
        )
