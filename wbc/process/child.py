"""A child process that runs one module of the library, seen from its parent.

Unlike `multiprocessing`, this needs no `__main__` guard in scripts, and the child imports only what
its module needs. The child's standard input is its end of a `multiprocessing.Pipe`, which carries
messages and file descriptors of shared memory. The child replies to the first message, and ends
when the pipe is closed: a parent that dies, even by SIGKILL, ends it. `wbc.process.parent` is the
child's side.
"""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import subprocess
import sys
import weakref
from collections.abc import Sequence
from multiprocessing.connection import Connection
from multiprocessing.reduction import send_handle
from pathlib import Path
from typing import Any

import wbc
from wbc.errors import WbcError

logger = logging.getLogger(__name__)

_START_TIMEOUT = 60.0  # s; on a busy machine the imports alone take many seconds
_CHECK_PERIOD = 0.5  # s between two checks whether the process still runs


class ProcessStartError(WbcError):
    """The child process did not start, or reported an error."""


class ChildProcess:
    """A child process that runs a module of the library.

    Args:
        module: name of the module, e.g. "wbc.view.server".
        descriptors: file descriptors that the child inherits.
        grace: time that the child gets to end by itself when it is asked to, s; it is then killed.
        title: name of the process in messages.
    """

    def __init__(
        self,
        module: str,
        descriptors: Sequence[int] = (),
        grace: float = 2.0,
        title: str = "a child",
    ) -> None:
        self._title = title
        self._next_check = 0.0
        paths = [str(Path(wbc.__file__).resolve().parent.parent), *(p for p in sys.path if p)]
        self._connection, child_end = multiprocessing.Pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=child_end.fileno(),
            stdout=subprocess.DEVNULL,
            pass_fds=tuple(descriptors),
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,  # the parent alone handles Ctrl-C
        )
        child_end.close()
        self._finalizer = weakref.finalize(self, _end, self._process, self._connection, grace)

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    @property
    def exit_code(self) -> int | None:
        """Exit code, the negative signal number if a signal ended it; None while it runs."""
        return self._process.poll()

    def warn_if_exited(self, now: float) -> None:
        """Log a warning, once, when the process has ended. Cheap enough to call in every tick.

        Args:
            now: time by `time.perf_counter`, s.
        """
        if now < self._next_check:
            return
        self._next_check = now + _CHECK_PERIOD
        if not self.alive:
            self._next_check = float("inf")
            logger.warning(
                "%s's process has ended (exit code %s); the run continues without it",
                self._title,
                self.exit_code,
            )

    def configure(self, config: object) -> dict[str, Any]:
        """Send the configuration, which is the first message, and return the child's reply.

        Raises:
            ProcessStartError: the process did not start, or its reply is an error.
        """
        self.send(config)
        reply = self.receive(_START_TIMEOUT)
        if "error" in reply:
            raise ProcessStartError(reply["error"])
        if not reply:
            raise ProcessStartError("the process did not start; its own message is above")
        return reply

    def receive(self, timeout: float) -> dict[str, Any]:
        """Return the child's next reply; empty if it has died or does not reply in `timeout` s."""
        reply: dict[str, Any] = {}
        with contextlib.suppress(EOFError, OSError):
            reply = self._connection.recv() if self._connection.poll(timeout) else {}
        return reply

    def send(self, message: object, descriptor: int | None = None) -> None:
        """Send a message. This blocks while the child does not read: never call it in a tick.

        Args:
            message: to be pickled.
            descriptor: file descriptor that goes with it. The child gets one of its own, as the
                field `descriptor` of the message, which is a dataclass then.
        """
        # A dead process is noticed by its missing reply, or by `warn_if_exited`.
        with contextlib.suppress(OSError):
            self._connection.send((message, descriptor is not None))
            if descriptor is not None:
                send_handle(self._connection, descriptor, self.pid)

    def close(self) -> None:
        """Ask the process to end, and wait until it has."""
        self._next_check = float("inf")
        self._finalizer()


def _end(process: subprocess.Popen[bytes], connection: Connection[Any, Any], grace: float) -> None:
    connection.close()  # tells the child to end
    try:
        process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()  # only this ends a process that is stopped
        process.wait()
