"""The parent process, seen from its child; see `wbc.process.child`."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

from wbc.process.child import LENGTH

_STDIN = 0
_MOST = 1 << 20  # bytes at once


def begin() -> Any:
    """The first message. From here on Ctrl-C is left to the parent.

    Raises:
        SystemExit: the parent has died before it said anything.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    message = hear()
    if message is None:
        raise SystemExit(0)
    return message


def hear() -> Any:
    """The next message; None when the parent has closed its end, or has died."""
    head = _read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (size,) = LENGTH.unpack(head)
    data = _read(size)
    return pickle.loads(data) if len(data) == size else None


def _read(size: int) -> bytes:
    # Not from `sys.stdin`: a thread that waits there would keep the interpreter from ending.
    data = bytearray()
    while len(data) < size and (part := os.read(_STDIN, min(size - len(data), _MOST))):
        data += part
    return bytes(data)


def answer(message: dict[str, Any]) -> None:
    """Answer the first message. The only thing ever said.

    Afterwards nobody reads, and a full pipe would block: what is printed goes nowhere.
    """
    with contextlib.suppress(BrokenPipeError):  # a parent that died is noticed by `Lifeline`
        os.write(sys.stdout.fileno(), (json.dumps(message) + "\n").encode())
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, sys.stdout.fileno())


class Lifeline:
    """Notices that the parent has closed its end, or has died.

    Args:
        parent: its process id.
        heard: given every further message, in a thread of its own.
    """

    def __init__(self, parent: int, heard: Callable[[Any], object] = lambda _: None) -> None:
        self._parent, self._heard = parent, heard
        self._over = threading.Event()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while (message := hear()) is not None:
            self._heard(message)
        self._over.set()

    @property
    def cut(self) -> bool:
        """Whether the parent is gone: this process is to end."""
        return self._over.is_set() or os.getppid() != self._parent

    def wait(self, seconds: float) -> None:
        """Wait for its end, at most so long."""
        self._over.wait(seconds)
