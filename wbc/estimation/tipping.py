"""Soles that tip over an edge: the point where the pressure is stands still, not the centre."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wbc.estimation.kernels.moving_soles import tip
from wbc.geometry.wrench import centre_of_pressure
from wbc.robot import Robot

_EDGE = 0.8  # share of the way from the centre to an edge from which on the sole may tip over it
_LEAST_LOAD = 0.05  # share of the weight: where the pressure of a sole with less is, is not known


class TippingSoles:
    """Tells the filter of soles that may tip.

    A sole with its centre of pressure at an edge, such as that of a robot which is pushed, turns
    about that edge at some rad/s without slipping. Held for a slip, it would leave the base's
    velocity without a correction just when it matters.

    Args:
        robot: its soles and weight.
        rate: standard deviation of the rate at which a sole tips, rad/s; 0: none ever does.
    """

    def __init__(self, robot: Robot, rate: float) -> None:
        soles = robot.soles if rate > 0.0 else ()
        self._edges = [
            (i, sole.name, _EDGE * sole.half_length, _EDGE * sole.half_width)
            for i, sole in enumerate(soles)
            if not robot.point_feet[i]
        ]
        self._least = _LEAST_LOAD * robot.weight
        self._rate = rate

    def add(
        self,
        filter_: np.ndarray,
        held: list[bool],
        wrenches: Mapping[str, np.ndarray],
        time: float,
    ) -> None:
        """Add to the covariance what soles that stand may have tipped.

        Args:
            filter_: (1,) record of the filter.
            held: per sole, whether it stands.
            wrenches: sole name -> (6,) measured wrench from the ground in sole axes; N, N·m.
            time: since the last correction, s.
        """
        variance = (self._rate * time) ** 2
        for i, name, half_length, half_width in self._edges:
            if not held[i]:
                continue
            x, y, _ = centre_of_pressure(wrenches[name], self._least).tolist()
            about_x = variance if abs(y) > half_width else 0.0
            about_y = variance if abs(x) > half_length else 0.0
            if about_x + about_y > 0.0:
                tip(filter_, i, x, y, about_x, about_y)
