"""Motions of one coordinate in time: push-off, landing, crouch, and the soles' flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Moment = tuple[float, float, float]  # position m, velocity m/s, acceleration m/s²


class Profile:
    """A height over time whose acceleration is piecewise linear.

    Args:
        start: height at time 0, m.
        velocity: at time 0, m/s.
        times: (k,) of the knots, ascending from 0, s.
        accelerations: (k,) at the knots, m/s².
    """

    def __init__(
        self, start: float, velocity: float, times: np.ndarray, accelerations: np.ndarray
    ) -> None:
        self._t, self._a = np.asarray(times, dtype=float), np.asarray(accelerations, dtype=float)
        dt = np.diff(self._t)
        slope = np.diff(self._a) / dt
        self._jerk = np.append(slope, 0.0)
        self._v = np.full(len(self._t), velocity, dtype=float)
        self._z = np.full(len(self._t), start, dtype=float)
        for k, h in enumerate(dt):
            a, j, v = self._a[k], slope[k], self._v[k]
            self._v[k + 1] = v + h * (a + 0.5 * h * j)
            self._z[k + 1] = self._z[k] + h * (v + h * (0.5 * a + h * j / 6.0))

    @property
    def duration(self) -> float:
        """s."""
        return float(self._t[-1])

    @property
    def end(self) -> Moment:
        """Position, velocity and acceleration at the end."""
        return float(self._z[-1]), float(self._v[-1]), float(self._a[-1])

    def at(self, time: float) -> Moment:
        """Position, velocity and acceleration; held within the duration."""
        z, v, a = self.sample(np.array([time]))
        return float(z[0]), float(v[0]), float(a[0])

    def sample(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(k,) positions, velocities and accelerations at times (k,)."""
        t = np.clip(times, 0.0, self._t[-1])
        k = np.clip(np.searchsorted(self._t, t, side="right") - 1, 0, len(self._t) - 2)
        h, a, j, v = t - self._t[k], self._a[k], self._jerk[k], self._v[k]
        return (
            self._z[k] + h * (v + h * (0.5 * a + h * j / 6.0)),
            v + h * (a + 0.5 * h * j),
            a + h * j,
        )


_RISE = 0.3  # share of a stroke in which its acceleration builds up
_FALL = 0.2  # share in which it goes over to the final one


def stroke(start: float, velocity: float, end: Moment, begin: float = 0.0) -> Profile:
    """From a height and velocity to others by one burst of acceleration.

    The acceleration goes linearly from `begin` to a plateau and from there to its final value;
    duration T and plateau follow from the two ends: with A, B, C the unit shapes of plateau,
    begin and end, `Δv = T (a A₁ + a₀ B₁ + a₁ C₁)` and `Δz = v₀ T + T² (a A₂ + a₀ B₂ + a₁ C₂)`,
    a quadratic equation in T.

    Args:
        start: height, m.
        velocity: m/s.
        end: height, velocity and acceleration at the end.
        begin: acceleration at the start, m/s².
    """
    knots = np.array([0.0, _RISE, 1.0 - _FALL, 1.0])

    def unit(*accelerations: float) -> tuple[float, float]:
        z, v, _ = Profile(0.0, 0.0, knots, np.array(accelerations)).end
        return v, z

    height, speed, final = end
    plateau, first, last = unit(0, 1, 1, 0), unit(1, 0, 0, 0), unit(0, 0, 0, 1)
    rest = [begin * f + final * e for f, e in zip(first, last, strict=True)]
    ratio = plateau[1] / plateau[0]
    square = rest[1] - rest[0] * ratio
    linear = velocity + (speed - velocity) * ratio
    roots = np.roots([square, linear, start - height])
    duration = min(float(r.real) for r in roots if abs(r.imag) < 1e-12 and r.real > 0.0)
    a = ((speed - velocity) / duration - rest[0]) / plateau[0]
    return Profile(start, velocity, duration * knots, np.array([begin, a, a, final]))


@dataclass(frozen=True, slots=True)
class Glide:
    """From rest to rest with least jerk: a quintic.

    Attributes:
        start: at time 0.
        end: at time `duration`.
        duration: s.
    """

    start: float
    end: float
    duration: float

    def at(self, time: float) -> Moment:
        """Position, velocity and acceleration; held within the duration."""
        T = self.duration
        x = min(max(time / T, 0.0), 1.0)
        way = self.end - self.start
        return (
            self.start + way * x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
            way / T * 30.0 * (x * (1.0 - x)) ** 2,
            way / T**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )


@dataclass(frozen=True, slots=True)
class Hop:
    """Height of the soles in flight: `64 c x³ (1 − x)³ + v T x³ (1 − x)`, x = t / T.

    It leaves the ground at rest and without acceleration, as the push-off ends, is c high in
    the middle, and comes down with v at T; from there it goes on down at v.

    Attributes:
        duration: T, s.
        clearance: c, m.
        touchdown: v, m/s.
    """

    duration: float
    clearance: float
    touchdown: float

    def at(self, time: float) -> Moment:
        """Height (m), velocity and acceleration at a time since take-off."""
        z, v, a = self.sample(np.array([time]))
        return float(z[0]), float(v[0]), float(a[0])

    def sample(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(k,) heights, velocities and accelerations at times (k,)."""
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
