"""Sway: the centre of mass on a circle or a figure of eight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.ik.posture_checks import support_half_size
from wbc.motions.engine import Motion, MotionContext, Script, check_positive, parameter
from wbc.robot import Robot

_SUPPORT = 0.86  # share of the support that the motion may use


@dataclass(frozen=True)
class Sway(Motion):
    """Move the CoM on a circle or a figure of eight over standing feet."""

    name: ClassVar[str] = "sway"
    summary: ClassVar[str] = "move the centre of mass on a circle or a figure of eight"

    size: float = parameter(0.04, "radius of the circle, or half the length of the eight, m")
    frequency: float = parameter(0.5, "frequency of the rounds, Hz")
    shape: str = parameter("circle", "shape of the path", choices=("circle", "eight"))
    rounds: float = parameter(4.0, "number of rounds")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "size", "frequency", "rounds")
        support, share = support_half_size(robot), 0.0
        for angle in np.linspace(0.0, 2.0 * math.pi, 33):
            share = max(share, float((np.abs(self._zmp(robot, angle)) / support).max()))
        if share > _SUPPORT:
            raise MotionError(
                f"sway: the {self.shape} of {self.size:g} m at {self.frequency:g} Hz needs "
                f"{100.0 * share:.0f} % of {robot.name}'s support, where "
                f"{100.0 * _SUPPORT:.0f} % leave some to balance: size at most "
                f"{self.size * _SUPPORT / share:.3f} m, or slower"
            )

    def _zmp(self, robot: Robot, angle: float) -> np.ndarray:
        """Return the ZMP c − c̈ / ω², from the middle of the soles, (2,) m."""
        rate = 2.0 * math.pi * self.frequency
        ratio = rate * rate * robot.com_height / robot.gravity
        c = self.com_offset(angle / rate)[:2]
        harmonic = np.array([1.0, 1.0 if self.shape == "circle" else 4.0])
        return np.asarray(c * (1.0 + ratio * harmonic))

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        context.com.follow(self.com_offset, blend=1.0 / self.frequency)
        yield from context.wait(self.rounds / self.frequency)
        context.com.move_to(0.0, 1.0)
        yield from context.until_arrived(context.com)

    def com_offset(self, time: float) -> np.ndarray:
        """Return the offset of the CoM at a time, s; (3,) m."""
        angle = 2.0 * math.pi * self.frequency * time
        if self.shape == "circle":
            return self.size * np.array([math.sin(angle), math.cos(angle), 0.0])
        return self.size * np.array([math.sin(angle), 0.5 * math.sin(2.0 * angle), 0.0])
