"""What the log's process lets the loop's process know."""

from __future__ import annotations

from wbc.process import SharedMemory

_TEXT = 240  # bytes
_LOST, _STOPPED = 0, 1
_HEAD = 16  # bytes


class LogStatus:
    """Two counters and a text in shared memory, which only the log's process writes.

    Args:
        descriptor: file descriptor of memory made in another process; None makes new memory.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(_HEAD + _TEXT, descriptor)
        self._counters = self._memory.view[:_HEAD].cast("Q")
        self._text = self._memory.view[_HEAD:]

    @property
    def descriptor(self) -> int:
        """File descriptor for the log's process."""
        return self._memory.descriptor

    @property
    def lost(self) -> int:
        """Ticks that were overwritten before they were written to the file."""
        return int(self._counters[_LOST])

    @lost.setter
    def lost(self, count: int) -> None:
        self._counters[_LOST] = count

    def stop(self, reason: str) -> None:
        """Tell that nothing is written any more, and why."""
        text = reason.encode("utf-8", "replace")[:_TEXT]
        self._text[: len(text)] = text
        self._counters[_STOPPED] = 1 + len(text)

    @property
    def stopped(self) -> bool:
        """Whether nothing is written any more."""
        return self._counters[_STOPPED] != 0

    @property
    def reason(self) -> str:
        """Why nothing is written any more; empty while something is."""
        size = max(int(self._counters[_STOPPED]) - 1, 0)
        return bytes(self._text[:size]).decode("utf-8", "ignore")

    def close(self) -> None:
        """Close the descriptor."""
        self._memory.close()
