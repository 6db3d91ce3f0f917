"""What stays of a run: a log, a recording, a film."""

from __future__ import annotations

import argparse
import contextlib
from typing import Any

import numpy as np

from wbc.cli.parser import output
from wbc.cli.progress import Rendering
from wbc.log import FlightRecorder
from wbc.robot import Robot
from wbc.view import Recording, Video


def add_keepsake_options(parser: Any) -> None:
    """The options for files that a run leaves, to a parser or a group of its options."""
    parser.add_argument(
        "--log",
        type=output,
        metavar="FILE.mcap",
        help="keep every tick, for wbc plot, diff and replay, Foxglove and PlotJuggler",
    )
    parser.add_argument(
        "--html", type=output, metavar="FILE", help="leave a recording that opens offline"
    )
    parser.add_argument(
        "--video", type=output, metavar="FILE.mp4", help="leave a film, rendered after the run"
    )


class Keepsakes:
    """The files that a run leaves, as the options say.

    Args:
        options: parsed, see `add_keepsake_options`.
        robot: the robot.
        boxes: (n, 6) terrain.

    Attributes:
        recording: to be shown the run; None if nothing is drawn of it.

    Raises:
        WbcError: what a film needs is not installed.
    """

    def __init__(self, options: argparse.Namespace, robot: Robot, boxes: np.ndarray) -> None:
        self._options = options
        self._robot = robot
        self._video = Video(options.video) if options.video is not None else None
        drawn = options.html is not None or self._video is not None
        self.recording = Recording(robot, boxes=boxes) if drawn else None

    def logs(self, stack: contextlib.ExitStack) -> list[FlightRecorder]:
        """The logs of the run, one or none; finished when the stack unwinds.

        Raises:
            WbcError: the log cannot be written.
        """
        if self._options.log is None:
            return []
        return [stack.enter_context(FlightRecorder(self._options.log, self._robot))]

    def finish(self) -> None:
        """Write what is written after the run, and say where everything is.

        Raises:
            WbcError: a file cannot be written.
        """
        if self._options.log is not None:
            print(f"\nlog: {self._options.log.resolve()}")
        if self.recording is None:
            return
        if self._options.html is not None:
            print(f"\nrecording: {self.recording.save(self._options.html).resolve()}")
        if self._video is not None:
            with Rendering() as rendering:
                path = self._video.render(self.recording, rendering.show)
            print(f"\nvideo: {path.resolve()}")
