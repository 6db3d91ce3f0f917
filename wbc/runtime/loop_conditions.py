"""Under which conditions a real-time loop runs: what it asked for, and what it got."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SystemRequest:
    """One thing that was asked of the system.

    Attributes:
        what: e.g. `"memory locked"`.
        granted: whether it is so.
        why: for a refusal, the reason or the cure; may be empty.
    """

    what: str
    granted: bool
    why: str = ""


@dataclass(frozen=True, slots=True)
class LoopConditions:
    """What a real-time loop got of all that keeps its ticks punctual, told before the first.

    Attributes:
        grants: in the order in which they were asked for.
    """

    grants: tuple[SystemRequest, ...]

    @property
    def granted(self) -> tuple[str, ...]:
        """What is so."""
        return tuple(g.what for g in self.grants if g.granted)

    @property
    def refused(self) -> tuple[str, ...]:
        """What is not."""
        return tuple(g.what for g in self.grants if not g.granted)

    def describe(self) -> str:
        """All of it in one line; refusals with their cure."""
        text = "real-time loop: " + (", ".join(self.granted) or "nothing granted")
        refusals = [
            f"{g.what} ({g.why})" if g.why else g.what for g in self.grants if not g.granted
        ]
        return text + ("; refused: " + ", ".join(refusals) if refusals else "")
