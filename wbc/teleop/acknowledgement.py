"""Acknowledgement of a command to its sender."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from wbc.errors import WbcError


class CommandRefused(WbcError, ValueError):
    """A command cannot be carried out; the text names the value and the cure."""


class CommandOutcome(Enum):
    """The outcome of a command.

    Every command is accepted or refused. A motion and a reset take time: after `ACCEPTED` follows
    one of `DONE`, `SUPERSEDED` and `ABORTED`. So does `ABORTED` after a velocity whose sender has
    fallen silent.
    """

    ACCEPTED = "accepted"  #: applied before a tick
    REFUSED = "refused"  #: not applied
    SUPERSEDED = "superseded"  #: another command took its place
    DONE = "done"  #: the motion is over and the robot stands, or the reset is complete
    ABORTED = "aborted"  #: the robot gave up the motion, or stopped when the timeout was over


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """The message that informs the sender of a command of its outcome.

    Attributes:
        id: number of the command, see `SentCommand`.
        outcome: outcome of the command.
        reason: why, unless it was accepted or done.
        time: time of the plant when it was decided, s; NaN if the command did not reach the loop.
    """

    id: int
    outcome: CommandOutcome
    reason: str = ""
    time: float = float("nan")
