"""`Meshcat`: a live view of a run in a browser, from a process of its own."""

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
import time
import weakref
import webbrowser
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

import wbc
from wbc.snapshot import Snapshot
from wbc.view.due import next_due
from wbc.view.errors import ViewerError
from wbc.view.order import Order
from wbc.view.recording import Recording
from wbc.view.ring import Ring
from wbc.view.slot import Layout
from wbc.view.terrain import checked_boxes

if TYPE_CHECKING:
    from wbc.robot import Robot

logger = logging.getLogger(__name__)

_PATIENCE = 30.0  # s, for the process to start
_LOOK = 0.5  # s, between two looks whether it is still there
_GRACE = 2.0  # s, for it to end by itself


class Meshcat:
    """Shows a robot in a browser while a loop runs.

    The loop's process only copies a snapshot into shared memory, some
    microseconds; everything else happens in another process, which may be slow,
    stopped or dead without any harm to the loop.

    Args:
        robot: the robot.
        port: of the page on this machine; None takes the first free one from
            7000 on, 0 any free one.
        rate: frames per second, Hz.
        record: also make a recording, written to this path when the viewer closes.
        open: open the page in the browser.
        boxes: (n, 6) terrain, upright boxes: centre, then half sizes, m.
        announce: print the page's address.

    Attributes:
        url: address of the page; it answers on this machine only.

    Raises:
        ViewerError: the process does not start, the port is taken, or `rate` or `boxes` make no
            sense.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        port: int | None = None,
        rate: float = 30.0,
        record: str | Path | None = None,
        open: bool = False,
        boxes: np.ndarray | None = None,
        announce: bool = True,
    ) -> None:
        if not rate > 0.0:
            raise ViewerError(f"rate is {rate} Hz; a viewer needs a positive one")
        self.rate = float(rate)
        self._ring = Ring(Layout.of(robot.model))
        self._record = Path(record) if record is not None else None
        self._recording = Recording(robot, boxes=boxes) if record is not None else None
        self._due = self._look = 0.0
        self._process = _start(self._ring.descriptor)
        self._stop = weakref.finalize(self, _end, self._process)
        order = Order(
            # A fresh copy: meshes that the caller has looked at stay at home.
            replace(robot),
            self._ring.descriptor,
            port,
            self.rate,
            checked_boxes(boxes),
            os.getpid(),
        )
        try:
            self.url = _introduce(self._process, order)
        except BaseException:
            self.close()
            raise
        if announce:
            print(f"Viewer: {self.url}", flush=True)
        if open:
            webbrowser.open(self.url)

    @property
    def alive(self) -> bool:
        """Whether the viewer's process is there."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """Of the viewer's process."""
        return self._process.pid

    def due(self, now: float) -> bool:
        """Whether showing something now would be seen.

        A fast loop asks this first, and saves itself the making of a snapshot.

        Args:
            now: the run's own time, s.
        """
        if self._recording is not None and self._recording.due(now):
            return True
        return time.perf_counter() >= self._due

    def show(self, snapshot: Snapshot) -> None:
        """Show a snapshot. Never waits; whatever happens to the viewer, returns.

        Raises:
            StateError: `snapshot.q` has the wrong size.
            ViewerError: another part of it has the wrong shape.
        """
        now = time.perf_counter()
        if now >= self._due:
            self._due = next_due(self._due, now, 1.0 / self.rate)
        self._ring.write(snapshot)
        if self._recording is not None:
            self._recording.show(snapshot)
        if now >= self._look:
            self._look_after(now)

    def _look_after(self, now: float) -> None:
        """Report the end of the process, once."""
        self._look = now + _LOOK
        if self._process.poll() is not None:
            self._look = float("inf")
            logger.warning(
                "the viewer's process has ended (exit code %s); the run goes on without it",
                self._process.returncode,
            )

    def close(self) -> None:
        """End the viewer's process, and write the recording if there is one."""
        self._look = float("inf")
        self._stop()
        self._ring.close()
        recording, self._recording = self._recording, None
        if recording is not None and self._record is not None and len(recording):
            recording.save(self._record)

    def __enter__(self) -> Meshcat:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _start(descriptor: int) -> subprocess.Popen[bytes]:
    # A module of its own, not multiprocessing: scripts need no `__main__` guard.
    paths = [str(Path(wbc.__file__).resolve().parent.parent), *(p for p in sys.path if p)]
    return subprocess.Popen(
        [sys.executable, "-m", "wbc.view.server"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        pass_fds=(descriptor,),
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        start_new_session=True,
    )


def _introduce(process: subprocess.Popen[bytes], order: Order) -> str:
    """Hand over the order; the address of the page comes back."""
    assert process.stdin is not None
    assert process.stdout is not None
    message = pickle.dumps(order)
    with contextlib.suppress(BrokenPipeError):  # the answer, or its absence, tells why
        process.stdin.write(struct.pack("<Q", len(message)) + message)
        process.stdin.flush()
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        line = process.stdout.readline() if selector.select(_PATIENCE) else b""
    process.stdout.close()
    answer = json.loads(line) if line else {}
    if "url" in answer:
        return str(answer["url"])
    raise ViewerError(
        answer.get("error", "the viewer's process did not start; its own message is above")
    )


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.stdin is not None:
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()  # the sign to end
    try:
        process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        process.kill()  # it may be stopped, which only this ends
        process.wait()
