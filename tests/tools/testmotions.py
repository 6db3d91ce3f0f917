"""Motions for tests of how motions are planned and played in several processes."""

import os
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions import Motion, parameter


@dataclass(frozen=True)
class Shrug(Motion):
    """A motion that only waits."""

    name: ClassVar[str] = "shrug"
    summary: ClassVar[str] = "nothing much"
    duration: float = parameter(0.1, "s")

    def play(self, context):
        yield from context.wait(self.duration)


@dataclass(frozen=True)
class SlowToPlan(Shrug):
    """A motion whose planning ends when a folder contains a file."""

    name: ClassVar[str] = "slow"
    folder: str = parameter("", "where")

    def check(self, robot):
        while self.folder and not os.listdir(self.folder):
            time.sleep(0.01)


@dataclass(frozen=True)
class Trip(Shrug):
    """A motion that aborts itself."""

    name: ClassVar[str] = "trip"

    def play(self, context):
        context.com.move_to(np.array([0.01, 0.0, 0.0]), 0.1)
        yield
        raise MotionError("trip: over its own feet")


@dataclass(frozen=True)
class Fly(Motion):
    """A motion that every robot refuses."""

    name: ClassVar[str] = "fly"
    summary: ClassVar[str] = "away"

    def check(self, robot):
        raise MotionError("fly: it has no wings")

    def play(self, context):
        yield
