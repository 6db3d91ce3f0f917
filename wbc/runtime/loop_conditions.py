"""Requests of a real-time loop to the system, and whether they were granted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SystemRequest:
    """One request to the system.

    Attributes:
        what: e.g. `"memory locked"`.
        granted: whether the system granted it.
        why: the reason of a refusal, or the cure; may be empty.
    """

    what: str
    granted: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class LoopConditions:
    """The requests of a real-time loop and their results, known before the first tick.

    Attributes:
        requests: the requests, in the order in which they were made.
    """

    requests: tuple[SystemRequest, ...]

    @property
    def granted(self) -> tuple[str, ...]:
        """The requests that were granted."""
        return tuple(r.what for r in self.requests if r.granted)

    @property
    def refused(self) -> tuple[str, ...]:
        """The requests that were refused."""
        return tuple(r.what for r in self.requests if not r.granted)

    def describe(self) -> str:
        """Return all requests in one line, refusals with their cure."""
        text = "real-time loop: " + (", ".join(self.granted) or "nothing granted")
        refusals = [
            f"{r.what} ({r.why})" if r.why else r.what for r in self.requests if not r.granted
        ]
        return text + ("; refused: " + ", ".join(refusals) if refusals else "")
