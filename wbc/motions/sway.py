"""Sway: the centre of mass on a circle or a figure of eight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.motions.body import Body
from wbc.motions.motion import Motion, Script, parameter, positive
from wbc.robot import Robot


@dataclass(frozen=True)
class Sway(Motion):
    """The CoM on a circle or a figure of eight over standing feet."""

    name: ClassVar[str] = "sway"
    summary: ClassVar[str] = "move the centre of mass on a circle or a figure of eight"

    size: float = parameter(0.04, "radius of the circle, half length of the eight, m")
    frequency: float = parameter(0.5, "rounds per second, Hz")
    shape: str = parameter("circle", "of the way", choices=("circle", "eight"))
    rounds: float = parameter(4.0, "how many")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        positive(self, "size", "frequency", "rounds")

    def play(self, body: Body) -> Script:
        """See `Motion.play`."""
        body.com.follow(self.place, blend=1.0 / self.frequency)
        yield from body.wait(self.rounds / self.frequency)
        body.com.go(0.0, 1.0)
        yield from body.arrive(body.com)

    def place(self, time: float) -> np.ndarray:
        """(3,) offset of the CoM at a time, m."""
        angle = 2.0 * math.pi * self.frequency * time
        if self.shape == "circle":
            return self.size * np.array([math.sin(angle), math.cos(angle), 0.0])
        return self.size * np.array([0.5 * math.sin(2.0 * angle), math.sin(angle), 0.0])
