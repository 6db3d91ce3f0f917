"""A child process that runs one of our modules, seen from its parent.

A module of its own, not multiprocessing: scripts need no `__main__` guard, and the child
imports only what it needs. It hears pickled messages on its standard input, answers the
first one with a line of JSON, and ends when its input does: a parent that dies, however it
dies, ends it. The child's side is in `wbc.process.parent`.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import pickle
import selectors
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

LENGTH = struct.Struct("<Q")
_PATIENCE = 60.0  # s, for the process to start: nothing compiled, on a machine that is busy
_LOOK = 0.5  # s, between two looks whether it is still there


class ChildError(WbcError):
    """The process did not start, or answered with an error."""


class Child:
    """A process of its own.

    Args:
        module: to be run, e.g. "wbc.view.server".
        descriptors: file descriptors that it inherits.
        grace: s, for it to end by itself when it is asked to; then it is killed.
        title: whose process it is, for people.
    """

    def __init__(
        self,
        module: str,
        descriptors: Sequence[int] = (),
        grace: float = 2.0,
        title: str = "a child",
    ) -> None:
        self._title = title
        self._look = 0.0
        paths = [str(Path(wbc.__file__).resolve().parent.parent), *(p for p in sys.path if p)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=tuple(descriptors),
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            start_new_session=True,  # Ctrl-C is the parent's business
        )
        self._end = weakref.finalize(self, _end, self._process, grace)

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it is there."""
        return self._process.poll() is None

    @property
    def exit_code(self) -> int | None:
        """How it ended; None while it runs. -9 was killed."""
        return self._process.poll()

    def look_after(self, now: float) -> None:
        """Tell, once, that it has ended; for a loop to call in every tick.

        Args:
            now: by `time.perf_counter`, s.
        """
        if now < self._look:
            return
        self._look = now + _LOOK
        if not self.alive:
            self._look = float("inf")
            logger.warning(
                "%s's process has ended (exit code %s); the run goes on without it",
                self._title,
                self.exit_code,
            )

    def introduce(self, order: object) -> dict[str, Any]:
        """Send the first message; its answer comes back.

        Raises:
            ChildError: the process does not start, or says why it cannot.
        """
        assert self._process.stdout is not None
        self.send(order)
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            line = self._process.stdout.readline() if selector.select(_PATIENCE) else b""
        self._process.stdout.close()
        answer: dict[str, Any] = json.loads(line) if line else {}
        if "error" in answer:
            raise ChildError(answer["error"])
        if not answer:
            raise ChildError("the process did not start; its own message is above")
        return answer

    def send(self, message: object) -> None:
        """Send a message. It may wait for a process that does not listen: never in a tick."""
        assert self._process.stdin is not None
        data = pickle.dumps(message)
        # A dead process is noticed by its missing answer, or by whoever looks after it.
        with contextlib.suppress(BrokenPipeError, ValueError):
            self._process.stdin.write(LENGTH.pack(len(data)) + data)
            self._process.stdin.flush()

    def close(self) -> None:
        """Ask it to end, and wait until it has."""
        self._look = float("inf")
        self._end()


def _end(process: subprocess.Popen[bytes], grace: float) -> None:
    if process.stdin is not None:
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()  # the sign to end
    try:
        process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()  # it may be stopped, which only this ends
        process.wait()
