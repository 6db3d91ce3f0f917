"""Files that a run or a replay writes: a log, a report, a recording, a video."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wbc.cli.argument_types import LogFile, OutputFile, VideoFile
from wbc.cli.output import OutputError, writing_results
from wbc.cli.progress import ProgressLine
from wbc.log import FlightRecorder
from wbc.robot import Robot
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.view import Recording, Video

_BAR_LENGTH = 30  # characters
_PERIOD = 10.0  # s between two lines of progress if they are not rewritten


@dataclass(frozen=True)
class OutputOptions:
    """Files that a run writes.

    Attributes:
        log: log every tick, for wbc plot, diff and replay, Foxglove and PlotJuggler.
        json: write the report as JSON.
        html: write a 3D recording that opens offline.
        video: write a video, rendered after the run.
    """

    log: LogFile | None = None
    json: OutputFile | None = None
    html: OutputFile | None = None
    video: VideoFile | None = None


class RunOutputs:
    """The files that a run writes.

    Args:
        options: the files to write.
        robot: the robot.
        boxes: boxes of the terrain; see `wbc.sim.Terrain`.

    Raises:
        WbcError: a package that a video needs is not installed.
    """

    def __init__(self, options: OutputOptions, robot: Robot, boxes: np.ndarray) -> None:
        self._options, self._robot = options, robot
        self._video = None if options.video is None else Video(options.video)
        self._recording = Recording(robot, boxes=boxes)

    def open_observers(self, stack: contextlib.ExitStack) -> list[Observer]:
        """Open the requested log, which is completed when the stack unwinds; add the recording.

        Raises:
            WbcError: the log cannot be written.
        """
        observers: list[Observer] = []
        if self._options.log is not None:
            observers.append(stack.enter_context(FlightRecorder(self._options.log, self._robot)))
        if self._options.html is not None or self._video is not None:
            observers.append(self._recording)
        return observers

    def write(self, report: Report) -> None:
        """Write the files that are made after the run, and print the paths of all files.

        Raises:
            OutputError: a file cannot be written.
        """
        with contextlib.ExitStack() as stack:
            # Each file is written even if another cannot be.
            stack.callback(write_recording, self._recording, self._options.html, self._video)
            if any(vars(self._options).values()):
                print()
            if self._options.log is not None:
                print(f"log: {self._options.log.resolve()}")
            if (path := self._options.json) is not None:
                try:
                    report.save(path)
                except OSError as error:
                    raise OutputError(f"cannot write {path}: {error.strerror}") from error


def write_recording(recording: Recording, html: Path | None, video: Video | None) -> None:
    """Write a page and a video of a recording, and print their paths.

    Raises:
        OutputError: a file cannot be written.
    """
    with writing_results():
        if html is not None:
            print(f"recording: {recording.save(html).resolve()}")
        if video is not None:
            with ProgressLine(_PERIOD) as line:
                start = time.monotonic()

                def show(done: int, frames: int) -> None:
                    elapsed = time.monotonic() - start
                    full = round(_BAR_LENGTH * done / frames)
                    bar = "█" * full + "·" * (_BAR_LENGTH - full)
                    left = elapsed / done * (frames - done)
                    line.show(f"[{bar}] frame {done} of {frames}, {left:.0f} s left", elapsed)

                path = video.render(recording, show)
            print(f"video: {path.resolve()}")
