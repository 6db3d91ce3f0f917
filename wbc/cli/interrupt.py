"""Ctrl-C that lets a run end by itself."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType


@contextlib.contextmanager
def interruptible() -> Iterator[list[int]]:
    """Ctrl-C asks for the end instead of tearing the tick apart; a second one does not ask.

    Yields:
        A list that is empty until then.
    """
    asked: list[int] = []

    def ask(signum: int, _: FrameType | None) -> None:
        if asked:
            raise KeyboardInterrupt
        asked.append(signum)

    try:
        before = signal.signal(signal.SIGINT, ask)
    except ValueError:  # not in the main thread, which alone gets signals
        yield asked
        return
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
