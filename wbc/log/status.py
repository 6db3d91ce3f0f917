"""The status that the log writer reports to the process of the control loop."""

from __future__ import annotations

from wbc.process import SharedMemory

_TEXT = 240  # bytes
_LOST, _STOPPED = 0, 1
_HEAD = 16  # bytes


class LogStatus:
    """A counter, a flag and a text in shared memory that only the log writer modifies.

    Args:
        descriptor: File descriptor of memory created by another process; None creates new
            memory.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(_HEAD + _TEXT, descriptor)
        self._counters = self._memory.view[:_HEAD].cast("Q")
        self._text = self._memory.view[_HEAD:]

    @property
    def descriptor(self) -> int:
        """File descriptor to pass to the log writer."""
        return self._memory.descriptor

    @property
    def lost(self) -> int:
        """Number of ticks that were overwritten in the stream before they reached the file."""
        return int(self._counters[_LOST])

    @lost.setter
    def lost(self, count: int) -> None:
        self._counters[_LOST] = count

    def stop(self, reason: str) -> None:
        """Report that logging has stopped, and why."""
        text = reason.encode("utf-8", "replace")[:_TEXT]
        self._text[: len(text)] = text
        self._counters[_STOPPED] = 1 + len(text)

    @property
    def stopped(self) -> bool:
        """Whether logging has stopped."""
        return self._counters[_STOPPED] != 0

    @property
    def reason(self) -> str:
        """Why logging has stopped; empty while it continues."""
        size = max(int(self._counters[_STOPPED]) - 1, 0)
        return bytes(self._text[:size]).decode("utf-8", "ignore")

    def close(self) -> None:
        """Close the descriptor."""
        self._memory.close()
