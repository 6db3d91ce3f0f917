"""Files that a run writes: a log, a recording, a video, a report."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import numpy as np

from wbc.cli.output import OutputError
from wbc.cli.parser import output_file
from wbc.cli.progress import RenderingProgress
from wbc.errors import WbcError
from wbc.log import FlightRecorder
from wbc.robot import Robot
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.view import Recording, Video


def add_output_options(parser: Any) -> None:
    """Add the options for files that a run writes to a parser or an argument group."""
    parser.add_argument(
        "--log",
        type=output_file,
        metavar="FILE.mcap",
        help="log every tick, for wbc plot, diff and replay, Foxglove and PlotJuggler",
    )
    parser.add_argument(
        "--html", type=output_file, metavar="FILE", help="write a 3D recording that opens offline"
    )
    parser.add_argument(
        "--video",
        type=output_file,
        metavar="FILE.mp4",
        help="write a video, rendered after the run",
    )


class RunOutputs:
    """The files that a run writes.

    Args:
        options: parsed options, see `add_output_options`.
        robot: the robot.
        boxes: boxes of the terrain, shape (n, 6).

    Attributes:
        recording: observer of the run; None if neither a recording nor a video is requested.

    Raises:
        WbcError: a package that a video needs is not installed.
    """

    def __init__(self, options: argparse.Namespace, robot: Robot, boxes: np.ndarray) -> None:
        self._options = options
        self._robot = robot
        self._video = Video(options.video) if options.video is not None else None
        record = options.html is not None or self._video is not None
        self.recording = Recording(robot, boxes=boxes) if record else None

    def open_observers(self, stack: contextlib.ExitStack) -> list[Observer]:
        """Open the requested log, which is completed when the stack unwinds; add the recording.

        Raises:
            WbcError: the log cannot be written.
        """
        observers: list[Observer] = []
        if self._options.log is not None:
            observers.append(stack.enter_context(FlightRecorder(self._options.log, self._robot)))
        if self.recording is not None:
            observers.append(self.recording)
        return observers

    def write(self) -> None:
        """Write the files that are made after the run, and print the paths of all files.

        Raises:
            OutputError: a file cannot be written.
        """
        if self._options.log is not None:
            print(f"\nlog: {self._options.log.resolve()}")
        if self.recording is None:
            return
        try:
            if self._options.html is not None:
                print(f"\nrecording: {self.recording.save(self._options.html).resolve()}")
            if self._video is not None:
                with RenderingProgress() as progress:
                    path = self._video.render(self.recording, progress.show)
                print(f"\nvideo: {path.resolve()}")
        except WbcError as error:
            raise OutputError(str(error)) from error


def write_report(report: Report, options: argparse.Namespace) -> None:
    """Write the report to the file of `--json`, if requested.

    Raises:
        OutputError: the file cannot be written.
    """
    if options.json is not None:
        try:
            report.save(options.json)
        except OSError as error:
            raise OutputError(f"cannot write {options.json}: {error.strerror}") from error
