"""The inputs of the QP as a quantity of the tick: what a log needs to solve the tick again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wbc.runtime.schema import Quantity

if TYPE_CHECKING:
    from wbc.robot import Robot
    from wbc.runtime.tick import Tick

NAME = "controller_inputs"
# A walk takes 300 and 14, each hand in contact 80, a coupling of two joints 30.
_WORDS, _WORDS_PER_JOINT, _WORDS_PER_COUPLING = 1024, 16, 32


@dataclass(frozen=True)
class ControllerInputs:
    """Reads the packed inputs of a tick's command.

    Attributes:
        words: numbers that are reserved for them.
    """

    words: int

    def __call__(self, tick: Tick) -> np.ndarray | float:
        """Return the inputs, (words,), see `wbc.qp.inputs`; NaN for a command that has none."""
        command = tick.command
        if command.source is None:
            return np.nan
        return command.source.packed_inputs(command, self.words)


def controller_inputs(robot: Robot) -> Quantity:
    """Return the quantity of a robot's controller inputs."""
    words = _WORDS + _WORDS_PER_JOINT * robot.na + _WORDS_PER_COUPLING * len(robot.couplings)
    return Quantity(
        NAME,
        ControllerInputs(words),
        "tasks, contacts and limits that the controller's QP was made of",
        size=words,
        message="packed",
        topic=NAME,
    )
