"""States of the safety layer, and the transitions between them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

_log = logging.getLogger(__name__)


class SafetyState(Enum):
    """What a robot is doing; every state but the last may only go to the next one or to DAMPING."""

    DAMPING = "damping"  #: joints are damped; also the end of every run and of every fault
    POSTURE = "posture"  #: the joints move slowly to the nominal posture and hold it
    STANDING = "standing"  #: the controller takes over from the posture within a moment
    CONTROL = "control"  #: the controller commands the robot


@dataclass(frozen=True, slots=True)
class Transition:
    """One transition.

    Attributes:
        time: time of the robot's clock, s.
        state: the state from then on.
        reason: why.
    """

    time: float
    state: SafetyState
    reason: str

    def __str__(self) -> str:
        return f"{self.time:.3f} s: {self.state.value}: {self.reason}"


def log_transition(transition: Transition) -> None:
    """Log a transition."""
    _log.warning("%s", transition)


#: Told of every transition.
OnTransition = Callable[[Transition], object]
