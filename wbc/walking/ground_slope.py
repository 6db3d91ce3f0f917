"""Slope of the ground, from the soles that stand on it."""

from __future__ import annotations

import math

from wbc.gait import GaitState, Phase

_TIME = 0.1  # s, time constant of the slope of one sole
_LANDED = 0.15  # s after which a sole that carries the robot lies flat
_STEPS = 3  # soles, one after the other, that have to agree
_LEVEL = 0.02  # slope that counts as none: noise
_STEEPEST = 0.4


class GroundSlope:
    """What the slopes of the last soles that carried the robot have in common.

    A slope is the rise per metre along world x, and along y as the imaginary part; that of a sole
    that alone carries the robot is that of the ground below it. A ramp tilts one sole after
    the other by the same, stones and the edges of tiles do not: each component is the smallest of
    the last three soles, and zero if their signs differ.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start anew, on level ground."""
        self._last = [0j] * _STEPS
        self._common = 0j  # of the last soles, without the present one
        self._present = 0j
        self._swings = False
        self._ranges = _ranges(self._last[1:])

    def update(self, state: GaitState, soles: tuple[complex, complex], dt: float) -> complex:
        """Return the slope of the ground after dt.

        Args:
            state: phase and support.
            soles: slopes of the left and the right sole.
            dt: time since the last tick, s.
        """
        if state.phase is not Phase.SWING:
            if self._swings:
                self._last = [*self._last[1:], self._present]
                self._swings = False
                self._common = self._with_present()
                self._ranges = _ranges(self._last[1:])
            return self._common
        measured = soles[0 if state.support == "left" else 1]
        if state.time < _LANDED or not self._swings:
            self._swings, self._present = True, measured
            return self._common
        self._present += min(dt / _TIME, 1.0) * (measured - self._present)
        return self._with_present()

    def _with_present(self) -> complex:
        """Return what the present sole has in common with the two before."""
        along, across = self._ranges
        if along[0] <= 0.0 <= along[1] and across[0] <= 0.0 <= across[1]:  # as on level ground
            return 0j
        present = self._present
        return complex(_smallest(*along, present.real), _smallest(*across, present.imag))


def _ranges(slopes: list[complex]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return least and largest component of some slopes, along x and along y."""
    along, across = [s.real for s in slopes], [s.imag for s in slopes]
    return (min(along), max(along)), (min(across), max(across))


def _smallest(least: float, most: float, present: float) -> float:
    """Return the smallest of some components, from the range of all but the present one."""
    if present < least:
        least = present
    elif present > most:
        most = present
    if least <= 0.0 <= most:
        return 0.0
    size = min(least if least > 0.0 else -most, _STEEPEST)
    return math.copysign(max(size - _LEVEL, 0.0), least)
