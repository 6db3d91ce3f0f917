"""Writes a stretch of a session to a file: a log, or a recording that plays offline.

A process of its own does that, since it takes a second per minute and more: pages and commands do
not wait for it.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import secrets
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from wbc.live.errors import LiveError
from wbc.robot import Robot
from wbc.runtime.event import FALL, RESET
from wbc.runtime.event_queue import NumberedEvent
from wbc.runtime.schema import Schema
from wbc.runtime.snapshot import Snapshot

FileKind = Literal["log", "film"]
_SUFFIX: dict[FileKind, str] = {"log": "mcap", "film": "html"}
_FRAME_RATE = 25.0  # Hz
_NICENESS = 10
_KEPT = 3  # files


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a session.

    Attributes:
        robot: The robot.
        boxes: Terrain as boxes, see `wbc.sim.Terrain`.
        schema: Schema of the records.
        records: Records of its ticks, shape (n,).
        time: Their session times, s, shape (n,).
        events: What was done to the robot meanwhile, and what happened to it.
        event_times: Their session times, s.
    """

    robot: Robot
    boxes: np.ndarray
    schema: Schema
    records: np.ndarray
    time: np.ndarray
    events: tuple[NumberedEvent, ...]
    event_times: tuple[float, ...]

    def write(self, kind: FileKind, path: Path) -> None:
        """Write the file.

        Raises:
            WbcError: There is no tick, the file cannot be written, or a package is missing.
        """
        os.nice(_NICENESS)
        if kind == "log":
            from wbc.log.stretch import write_log

            stamps = np.round(1e9 * self.time).astype(np.int64)
            write_log(
                path, self.robot, self.schema, self.records, stamps,
                events=self.events, boxes=self.boxes,
            )  # fmt: skip
            return
        from wbc.view.recording import Marker, Recording

        recording = Recording(self.robot, rate=_FRAME_RATE, boxes=self.boxes)
        # A run of another number has its own time, which the recording continues.
        for record in self.records:
            recording.show(Snapshot.of_record(record))
        start = float(self.time[0]) - recording.times[0] if len(self.records) else 0.0
        recording.markers = [
            Marker(time - start, one.event.kind, one.event.reason)
            for time, one in zip(self.event_times, self.events, strict=True)
            if one.event.kind in (FALL, RESET)
        ]
        recording.save(path)


class SavedFiles:
    """The files that pages have asked for, in a folder that is removed at the end.

    Args:
        name: Name of the robot, with which the names of the files begin.
        folder: Folder of the run, in which that of the files is: it is removed with it if this
            process is killed.
    """

    def __init__(self, name: str, folder: Path) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="saved-", dir=folder)
        self._name = name
        self._tokens: list[str] = []
        self._busy = False

    async def save(self, kind: FileKind, stretch: Stretch) -> str:
        """Write a file; return the path by which the server offers it.

        Raises:
            LiveError: Another file is being written.
            WbcError: See `Stretch.write`.
        """
        if self._busy:
            raise LiveError("another file is being written: wait until it is there")
        token, name = secrets.token_hex(8), self._file_name(kind, stretch)
        path = Path(self._folder.name, token, name)
        path.parent.mkdir()
        self._busy = True
        try:
            # Not forked: this process has threads.
            spawn = multiprocessing.get_context("spawn")
            with ProcessPoolExecutor(1, spawn) as pool:
                loop = asyncio.get_running_loop()
                await loop.run_in_executor(pool, stretch.write, kind, path)
        except (OSError, RuntimeError) as error:
            raise LiveError(f"{name} cannot be written: {error}") from error
        finally:
            self._busy = False
        self._tokens.append(token)
        for old in self._tokens[:-_KEPT]:
            for file in Path(self._folder.name, old).glob("*"):
                file.unlink()
        return f"saved/{token}/{name}"

    def path(self, token: str, name: str) -> Path | None:
        """Return the path of a file that is offered, by the end of its address; None if none is."""
        path = Path(self._folder.name, token, name)
        return path if token in self._tokens and path.is_file() else None

    def _file_name(self, kind: FileKind, stretch: Stretch) -> str:
        first, last = (float(stretch.time[i]) if len(stretch.time) else 0.0 for i in (0, -1))
        name = "".join(c if c.isalnum() else "_" for c in self._name)
        return f"{name}_{first:.0f}s_to_{last:.0f}s.{_SUFFIX[kind]}"

    def close(self) -> None:
        """Remove the files."""
        self._folder.cleanup()
