"""The parent process, seen from its child; see `wbc.process.child`."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import socket
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from wbc.process.child import LENGTH

_STDIN = 0
_MAX_READ = 1 << 20  # bytes per system call


def receive_config() -> Any:
    """Return the first message, the configuration. From here on SIGINT is ignored.

    Raises:
        SystemExit: the parent died before it had sent a whole message.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    message = receive()
    if message is None:
        raise SystemExit(0)
    return message


def receive() -> Any:
    """Return the next message; None when the parent has closed its end or has died."""
    with socket.socket(fileno=os.dup(_STDIN)) as connection:
        head, descriptors, _, _ = socket.recv_fds(connection, LENGTH.size, 1)
    if not head:
        return None
    head += _read(LENGTH.size - len(head))
    if len(head) < LENGTH.size:
        return None
    (size,) = LENGTH.unpack(head)
    data = _read(size)
    if len(data) < size:
        return None
    message = pickle.loads(data)
    return replace(message, descriptor=descriptors[0]) if descriptors else message


def _read(size: int) -> bytes:
    # Not from `sys.stdin`: a thread that waits there would keep the interpreter from ending.
    data = bytearray()
    while len(data) < size and (part := os.read(_STDIN, min(size - len(data), _MAX_READ))):
        data += part
    return bytes(data)


def reply(message: dict[str, Any]) -> None:
    """Reply to the configuration, as a line of JSON on standard output.

    Nobody reads the pipe afterwards, and a full one would block: standard output is redirected to
    the null device.
    """
    with contextlib.suppress(BrokenPipeError):  # `ParentMonitor` notices a parent that died
        os.write(sys.stdout.fileno(), (json.dumps(message) + "\n").encode())
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, sys.stdout.fileno())


class ParentMonitor:
    """Notices when the parent has closed its end or has died.

    Args:
        parent: process id of the parent.
        on_message: called with every further message, in a thread of its own.
    """

    def __init__(self, parent: int, on_message: Callable[[Any], object] = lambda _: None) -> None:
        self._parent, self._on_message = parent, on_message
        self._closed = threading.Event()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while (message := receive()) is not None:
            self._on_message(message)
        self._closed.set()

    @property
    def gone(self) -> bool:
        """Whether the parent is gone, so that this process is to end."""
        return self._closed.is_set() or os.getppid() != self._parent

    def wait(self, timeout: float) -> None:
        """Wait until the parent has closed its end, at most `timeout` s."""
        self._closed.wait(timeout)
