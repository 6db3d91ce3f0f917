"""The base of observers that read the ticks of a run in a process of their own."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from wbc.closeable import Closeable
from wbc.process import ChildProcess, ProcessStartError

if TYPE_CHECKING:
    from wbc.errors import WbcError
    from wbc.runtime.protocols import Controller, Plant
    from wbc.runtime.report import Report
    from wbc.runtime.schema import Quantity
    from wbc.runtime.stream import TickStream
    from wbc.runtime.tick import Tick


class ProcessObserver(Closeable):
    """A `wbc.runtime.protocols.StreamObserver` whose child process reads the stream of ticks.

    The loop never waits for the process and continues when it has ended.

    Args:
        process: Child process, not yet configured.

    Attributes:
        stream: Stream that the process reads; None before the first run.
    """

    def __init__(self, process: ChildProcess) -> None:
        self.stream: TickStream | None = None
        self._process = process

    def _configure(self, config: object, error_type: type[WbcError], prefix: str = "") -> Any:
        """Send the configuration and return the reply; close the observer if that fails.

        Raises:
            WbcError: The process does not start; of the given type, its text begins with `prefix`.
        """
        try:
            return self._process.configure(config)
        except BaseException as error:
            self.close()
            if isinstance(error, ProcessStartError):
                raise error_type(f"{prefix}{error}") from error
            raise

    @property
    def alive(self) -> bool:
        """Whether the observer's process runs."""
        return self._process.alive

    @property
    def pid(self) -> int:
        """Process id of the observer's process."""
        return self._process.pid

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """No additional quantities; see `wbc.runtime.protocols.StreamObserver`."""
        return ()

    def attach(self, stream: TickStream) -> None:
        """Read a stream from now on; see `wbc.runtime.protocols.StreamObserver`."""
        self.stream = stream
        self._process.send(*stream.link())

    def begin(self, controller: Controller, plant: Plant) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def observe(self, tick: Tick) -> None:
        """Warn if the process has ended. The process reads the tick from the stream."""
        self._process.warn_if_exited(time.perf_counter())

    def end(self, report: Report) -> None:
        """Do nothing; see `wbc.runtime.protocols.Observer`."""

    def close(self) -> None:
        """End the process."""
        self._process.close()
