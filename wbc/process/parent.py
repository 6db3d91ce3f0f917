"""The parent process, seen from its child; see `wbc.process.child`."""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
from typing import Any

from wbc.process.child import LENGTH


def begin() -> Any:
    """The first message. From here on Ctrl-C is left to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return hear()


def hear() -> Any:
    """The next message; None when the parent has closed its end, or has died."""
    head = sys.stdin.buffer.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (size,) = LENGTH.unpack(head)
    data = sys.stdin.buffer.read(size)
    return pickle.loads(data) if len(data) == size else None


def answer(message: dict[str, Any]) -> None:
    """Answer the first message. The only thing ever said.

    Afterwards nobody reads, and a full pipe would block: what is printed goes nowhere.
    """
    os.write(sys.stdout.fileno(), (json.dumps(message) + "\n").encode())
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, sys.stdout.fileno())
