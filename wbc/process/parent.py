"""The parent process, seen from its child; see `wbc.process.child`."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import threading
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle
from typing import Any

logger = logging.getLogger(__name__)

_STDIN = 0


class ParentConnection:
    """A child's connection to its parent. From its creation on SIGINT and SIGTERM are
    ignored: the child ends when its parent does, for instance to finish its file.

    Attributes:
        config: Configuration, which is the parent's first message.

    Raises:
        SystemExit: The parent died before it had sent the configuration.
    """

    def __init__(self) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        self._pid = os.getppid()
        self._connection = Connection(os.dup(_STDIN))
        self._closed = threading.Event()
        try:
            self.config: Any = self._receive()
        except (EOFError, OSError):
            raise SystemExit(0) from None

    def reply(self, message: dict[str, Any]) -> None:
        """Reply to the configuration."""
        with contextlib.suppress(OSError):  # `gone` tells that the parent has died
            self._connection.send(message)

    def listen(self, on_message: Callable[[Any], object]) -> None:
        """Call a function with every further message, in a thread of its own.

        An exception that it raises is logged, and the next message is received.
        """
        threading.Thread(target=self._listen, args=(on_message,), daemon=True).start()

    @property
    def gone(self) -> bool:
        """Whether the parent has closed the connection or has died, so that the child is to end."""
        return self._closed.is_set() or os.getppid() != self._pid

    def wait(self, timeout: float) -> None:
        """Wait until the parent has closed the connection, at most `timeout` s."""
        self._closed.wait(timeout)

    def _listen(self, on_message: Callable[[Any], object]) -> None:
        try:
            while True:
                message = self._receive()
                try:
                    on_message(message)
                except Exception:
                    name = type(message).__name__
                    logger.exception("the parent's message %s could not be handled", name)
        except (EOFError, OSError):
            pass
        finally:
            self._closed.set()

    def _receive(self) -> Any:
        message, with_descriptor = self._connection.recv()
        if with_descriptor:
            return replace(message, descriptor=recv_handle(self._connection))
        return message
