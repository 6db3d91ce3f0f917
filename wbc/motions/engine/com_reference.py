"""Reference of the centre of mass that never leaves what the feet can support."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from wbc.errors import MotionError
from wbc.geometry.polygon import clamp_to_polygon
from wbc.geometry.quintic import evaluate_quintic
from wbc.motions.engine.reference import SAMPLES, Path, SmoothReference

# Shares of the support polygon, about the CoM's home, for the CoM at rest and the DCM in motion.
_REST, _MOVING = 0.9, 0.95
_EDGE = 0.012  # m from the edge of the support that balance needs at least
_WALKING = 0.01  # m that the CoM may be off while the robot steps
_MAX_VERTICAL_ACCELERATION = 8.0  # m/s²
_AHEAD = 0.4  # s that a path is checked in advance: the time to return from it
_EVERY = 10  # ticks between two checks of a path
_H = 0.01  # s, step of the differences along a path
_LONGEST = 10.0  # s
_LONGER = 1.15


class ComReference(SmoothReference):
    """An offset of the CoM, refused where the feet do not support it.

    At rest the CoM has to be above the support polygon; in motion the DCM ξ = c + ċ/ω has to
    be, or no ZMP brings it back (Koolen et al., Capturability-based analysis and control of
    legged locomotion, IJRR 2012). A path is checked 0.4 s ahead, so that a motion is aborted
    while there is time to return.

    Args:
        speed: limit of each component's speed, m/s.
        acceleration: limit of each component's acceleration, m/s².
        omega: natural frequency ω, 1/s.
        descent: returns how far the pelvis may sink from where it is before that nearly counts
            as a fall, m.
        support: returns the corners of the support polygon, counter-clockwise, relative to where
            the offset is zero, in the axes of the offset, m; empty while the robot steps.
    """

    def __init__(
        self,
        *,
        speed: float,
        acceleration: float,
        omega: float,
        descent: Callable[[], float],
        support: Callable[[], Sequence[complex]],
    ) -> None:
        self._omega, self._support = omega, support
        self._descent = descent
        self._ticks = 0
        super().__init__(np.zeros(3), speed=speed, acceleration=acceleration)

    @property
    def active(self) -> bool:
        """Whether the offset is, or is to be, away from home horizontally."""
        return self._path is not None or math.hypot(*self._goal[:2]) > _WALKING

    def move_to(self, target: np.ndarray | float, duration: float = 0.0) -> float:
        """See `SmoothReference.move_to`; it takes as long as the ZMP needs to stay above the soles.

        Raises:
            MotionError: the feet do not support the CoM there, or it is so low that it counts as
                fallen.
        """
        goal = self._vector(target)
        if goal.any():
            support = self._support()
            self._check(goal, goal, support, _REST, "the centre of mass cannot go")
            duration = self._supported(goal, duration, support)
        return super().move_to(goal, duration)

    def follow(self, path: Path, blend: float = 0.6) -> None:
        """See `SmoothReference.follow`.

        Raises:
            MotionError: the path leaves what the feet support; likewise later, in `advance`.
        """
        super().follow(path, blend)
        for time in np.arange(0.0, _AHEAD, _EVERY * self._dt):
            self._check_path(path, float(time))

    def advance(self, dt: float) -> None:
        """See `SmoothReference.advance`.

        Raises:
            MotionError: the path is about to leave what the feet support.
        """
        self._ticks += 1
        if self._path is not None and self._ticks % _EVERY == 0:
            self._check_path(self._path, self._since + _AHEAD)
        super().advance(dt)

    def _check_path(self, path: Path, time: float) -> None:
        before, now, after = (
            self._point(path, at) + self._difference_at(at) for at in (time - _H, time, time + _H)
        )
        vertical = abs(float(after[2] - 2.0 * now[2] + before[2])) / _H**2
        if vertical > _MAX_VERTICAL_ACCELERATION:
            raise MotionError(
                f"at {time:.2f} s of its path the centre of mass accelerates by {vertical:.3g} "
                f"m/s² up or down: at most {_MAX_VERTICAL_ACCELERATION:g} m/s²"
            )
        dcm = now + (after - before) / (2.0 * _H * self._omega)
        self._check(now, dcm, self._support(), _MOVING, f"at {time:.2f} s of its path the DCM goes")

    def _check(
        self,
        com: np.ndarray,
        dcm: np.ndarray,
        support: Sequence[complex],
        share: float,
        what: str,
    ) -> None:
        deepest = min(float(self.value[2]) - self._descent(), 0.0)
        if com[2] < deepest:
            raise MotionError(
                f"the centre of mass goes {-1e3 * com[2]:.0f} mm down: more than "
                f"{-1e3 * deepest:.0f} mm nearly counts as a fall"
            )
        if not support:
            if math.hypot(dcm[0], dcm[1]) > _WALKING:
                raise MotionError(f"{what} anywhere while the robot steps: only up and down")
            return
        share = min(share, 1.0 - _EDGE / _inradius(support))
        inner = [share * corner for corner in support]
        at = complex(float(dcm[0]), float(dcm[1]))
        beyond = abs(at - clamp_to_polygon(at, inner, 0.0))
        if beyond > 0.0:
            raise MotionError(
                f"{what} {1e3 * at.real:+.0f} mm forward and {1e3 * at.imag:+.0f} mm left: that is "
                f"{1e3 * beyond:.0f} mm beyond {100.0 * share:.0f} % of what the soles support"
            )

    def _supported(self, goal: np.ndarray, time: float, support: Sequence[complex]) -> float:
        """Return the least duration from `time` on in which the ZMP stays within the soles."""
        if not support:
            return time
        points = np.array([[p.real, p.imag] for p in support])
        low, high = points.min(axis=0), points.max(axis=0)
        time = max(time, 0.1)
        while time < _LONGEST:
            x, _, acceleration = evaluate_quintic(self._decay_to(goal, time), SAMPLES)
            zmp = (goal + x - acceleration / (time * self._omega) ** 2)[:, :2]
            if (zmp >= low).all() and (zmp <= high).all():
                break
            time *= _LONGER
        return time


def _inradius(polygon: Sequence[complex]) -> float:
    """Return the distance from the origin to the nearest side, m."""
    sides = zip(polygon, [*polygon[1:], polygon[0]], strict=True)
    return min(abs((a * (b - a).conjugate()).imag) / abs(b - a) for a, b in sides)
