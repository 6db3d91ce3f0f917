"""Handling of Ctrl-C and SIGTERM: an immediate exit while starting, an orderly end of a run."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Iterator
from typing import Any

from wbc.cli.exit_code import ExitCode


@contextlib.contextmanager
def exit_on_interrupt() -> Iterator[None]:
    """End the process silently on Ctrl-C, with exit code 130.

    For imports: a `KeyboardInterrupt` inside the initialization of an extension module may be
    turned into another error, or be printed and dropped.
    """
    with _handler(signal.SIGINT, lambda *_: os._exit(ExitCode.INTERRUPTED)):
        yield


@contextlib.contextmanager
def graceful_interrupt() -> Iterator[list[int]]:
    """Record Ctrl-C and SIGTERM; a second Ctrl-C raises `KeyboardInterrupt`.

    Yields:
        A list that contains the signal number once one of them came.
    """
    received: list[int] = []

    def record(signum: int, _: object) -> None:
        if received and signum == signal.SIGINT:
            raise KeyboardInterrupt
        received.append(signum)

    with _handler(signal.SIGINT, record), _handler(signal.SIGTERM, record):
        yield received


@contextlib.contextmanager
def _handler(number: signal.Signals, handler: Callable[[int, Any], None]) -> Iterator[None]:
    try:
        previous = signal.signal(number, handler)
    except ValueError:  # signals reach the main thread only
        yield
        return
    try:
        yield
    finally:
        signal.signal(number, previous)
