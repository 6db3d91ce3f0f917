"""A child process that runs one module of the library, seen from its parent.

Unlike `multiprocessing`, this needs no `__main__` guard in scripts, and the child imports only what
its module needs. The child reads pickled messages from its standard input, a socket that can also
carry file descriptors of shared memory. It answers the first message with a line of JSON, and ends
when its input is closed: a parent that dies, even by SIGKILL, ends it. `wbc.process.parent` is the
child's side.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import pickle
import selectors
import socket
import struct
import subprocess
import sys
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import wbc
from wbc.errors import WbcError

logger = logging.getLogger(__name__)

LENGTH = struct.Struct("<Q")  # precedes each message: its size, bytes
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
        title: what the process does, for messages.
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
        self._socket, child_end = socket.socketpair()
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=child_end.fileno(),
            stdout=subprocess.PIPE,
            pass_fds=tuple(descriptors),
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,  # the parent alone handles Ctrl-C
        )
        child_end.close()
        self._finalizer = weakref.finalize(self, _end, self._process, self._socket, grace)

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
                "%s's process has ended (exit code %s); the run goes on without it",
                self._title,
                self.exit_code,
            )

    def configure(self, config: object) -> dict[str, Any]:
        """Send the configuration, which is the first message, and return the child's reply.

        Raises:
            ProcessStartError: the process did not start, or its reply is an error.
        """
        assert self._process.stdout is not None
        self.send(config)
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            line = self._process.stdout.readline() if selector.select(_START_TIMEOUT) else b""
        self._process.stdout.close()
        reply: dict[str, Any] = json.loads(line) if line else {}
        if "error" in reply:
            raise ProcessStartError(reply["error"])
        if not reply:
            raise ProcessStartError("the process did not start; its own message is above")
        return reply

    def send(self, message: object, descriptor: int | None = None) -> None:
        """Send a message. This blocks while the child does not read: never call it in a tick.

        Args:
            message: to be pickled.
            descriptor: file descriptor that goes with it. The child gets one of its own, as the
                field `descriptor` of the message, which is a dataclass then.
        """
        data = pickle.dumps(message)
        head = LENGTH.pack(len(data))
        # A dead process is noticed by its missing reply, or by `warn_if_exited`.
        with contextlib.suppress(OSError):
            if descriptor is None:
                self._socket.sendall(head + data)
            else:
                socket.send_fds(self._socket, [head], [descriptor])
                self._socket.sendall(data)

    def close(self) -> None:
        """Ask the process to end, and wait until it has."""
        self._next_check = float("inf")
        self._finalizer()


def _end(process: subprocess.Popen[bytes], connection: socket.socket, grace: float) -> None:
    connection.close()  # tells the child to end
    try:
        process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()  # only this ends a process that is stopped
        process.wait()
