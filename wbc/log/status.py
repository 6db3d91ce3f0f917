"""The status that the log writer reports to the process of the control loop."""

from __future__ import annotations

import numpy as np

from wbc.process import SharedMemory

_STATUS = np.dtype([("dropped", np.uint64), ("reason", "S240")])


class LogStatus:
    """A counter and a text in shared memory that only the log writer modifies.

    Args:
        descriptor: File descriptor of memory created by another process; None creates new
            memory.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._memory = SharedMemory(_STATUS.itemsize, descriptor)
        self._status = np.frombuffer(self._memory.view, _STATUS)

    @property
    def descriptor(self) -> int:
        """File descriptor to pass to the log writer."""
        return self._memory.descriptor

    @property
    def dropped(self) -> int:
        """Number of ticks that were overwritten in the stream before they reached the file."""
        return int(self._status["dropped"][0])

    @dropped.setter
    def dropped(self, count: int) -> None:
        self._status["dropped"] = count

    @property
    def reason(self) -> str:
        """Why logging has stopped; empty while it continues."""
        return bytes(self._status["reason"][0]).decode("utf-8", "ignore")

    @reason.setter
    def reason(self, text: str) -> None:
        self._status["reason"] = text.encode("utf-8", "replace")

    def close(self) -> None:
        """Close the descriptor."""
        self._memory.close()
