"""Slope of the ground, from the soles that stand on it."""

from __future__ import annotations

import math

from wbc.gait import SWING, GaitState
from wbc.gait.footsteps import SIDES

_TIME = 0.1  # s, time constant of the slope of one sole
_LANDED = 0.15  # s after which a sole that carries the robot lies flat
_STEPS = 3  # soles, one after the other, that have to agree
_LEVEL = 0.02  # slope that counts as none: noise
_STEEPEST = 0.4

_Range = tuple[float, float]


class GroundSlope:
    """What the slopes of the last soles that carried the robot have in common.

    A slope is the rise per metre along world x, and along y as the imaginary part; that of a sole
    that alone carries the robot is that of the ground below it. A ramp tilts one sole after
    the other by the same, stones and the edges of tiles do not: each component is the smallest of
    the last three soles, and zero if their signs differ.

    Args:
        dt: time between two updates, s.
    """

    def __init__(self, dt: float) -> None:
        self._share = min(dt / _TIME, 1.0)
        self.reset()

    def reset(self) -> None:
        """Start anew, on level ground."""
        self._last = [0j] * _STEPS
        self._common = 0j  # of the last soles, without the present one
        self._present = 0j
        self._swings = False
        self._ranges = _ranges(self._last[1:])

    def update(self, state: GaitState, soles: tuple[complex, complex]) -> complex:
        """Return the slope of the ground after a period.

        Args:
            state: phase and support.
            soles: slopes of the left and the right sole.
        """
        if state.phase is not SWING:
            if self._swings:
                self._last = [*self._last[1:], self._present]
                self._swings = False
                self._common = self._with_present()
                self._ranges = _ranges(self._last[1:])
            return self._common
        measured = soles[SIDES.index(state.support)]
        if state.time < _LANDED or not self._swings:
            self._swings, self._present = True, measured
            return self._common
        self._present += self._share * (measured - self._present)
        return self._with_present()

    def _with_present(self) -> complex:
        """Return what the present sole has in common with the two before."""
        along, across = self._ranges
        present = self._present
        return complex(_smallest(along, present.real), _smallest(across, present.imag))


def _ranges(slopes: list[complex]) -> tuple[_Range | None, _Range | None]:
    """Return the ranges of the components of some slopes, along x and along y."""
    return _range([s.real for s in slopes]), _range([s.imag for s in slopes])


def _range(components: list[float]) -> _Range | None:
    """Return the smallest and the largest component; None if their signs differ."""
    least, most = min(components), max(components)
    return None if least <= 0.0 <= most else (least, most)


def _smallest(before: _Range | None, present: float) -> float:
    """Return the smallest of some components, from the range of all but the present one."""
    if before is None:
        return 0.0
    least, most = min(before[0], present), max(before[1], present)
    if least <= 0.0 <= most:
        return 0.0
    size = min(least if least > 0.0 else -most, _STEEPEST)
    return math.copysign(max(size - _LEVEL, 0.0), least)
