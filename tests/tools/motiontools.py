"""Motions for tests of how motions are planned and played in several processes."""

import os
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.motions import Motion, parameter


@dataclass(frozen=True)
class WaitingMotion(Motion):
    """A motion that only waits."""

    name: ClassVar[str] = "waiting"
    summary: ClassVar[str] = "waits"
    duration: float = parameter(0.1, "s")

    def play(self, context):
        yield from context.wait(self.duration)


@dataclass(frozen=True)
class SlowlyPlannedMotion(WaitingMotion):
    """A motion whose planning ends when a folder contains a file."""

    name: ClassVar[str] = "slowly_planned"
    folder: str = parameter("", "folder that ends the planning")

    def check(self, robot):
        while self.folder and not os.listdir(self.folder):
            time.sleep(0.01)


@dataclass(frozen=True)
class AbortingMotion(WaitingMotion):
    """A motion that aborts itself."""

    name: ClassVar[str] = "aborting"

    def play(self, context):
        context.com.move_to(np.array([0.01, 0.0, 0.0]), 0.1)
        yield
        raise MotionError("aborting: its script raised")


@dataclass(frozen=True)
class InfeasibleMotion(Motion):
    """A motion that every robot refuses."""

    name: ClassVar[str] = "infeasible_motion"
    summary: ClassVar[str] = "is refused"

    def check(self, robot):
        raise MotionError("infeasible_motion: no robot can do it")

    def play(self, context):
        yield
