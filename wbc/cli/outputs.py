"""Files that a run or a replay writes: a log, a report, a recording, a video."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wbc.cli.argument_types import LogFile, OutputFile, VideoCamera, VideoFile, VideoSize
from wbc.cli.output import OutputError, writing_results
from wbc.cli.progress import ProgressBar
from wbc.log import FlightRecorder
from wbc.robot import Robot
from wbc.runtime.protocols import Observer
from wbc.runtime.report import Report
from wbc.view import Recording, Video, VideoFormat


@dataclass(frozen=True)
class RecordingOptions:
    """What is shown of a run afterwards.

    Attributes:
        html: write a 3D recording that opens offline.
        video: write a video, rendered after the run.
        video_size: size of the video, pixels.
        video_rate: frames per second of the video.
        video_camera: where the video is seen from: azimuth from the robot's front to its left and
            elevation, degrees, and distance, m.
    """

    html: OutputFile | None = None
    video: VideoFile | None = None
    video_size: VideoSize = VideoFormat.size
    video_rate: float = VideoFormat.rate
    video_camera: VideoCamera | None = None

    def renderer(self) -> Video | None:
        """Return what renders the video; None without one.

        Raises:
            WbcError: a package is not installed, or the format is not possible.
        """
        if self.video is None:
            return None
        return Video(self.video, VideoFormat(self.video_size, self.video_rate, self.video_camera))


@dataclass(frozen=True)
class OutputOptions:
    """Files that a run writes.

    Attributes:
        recording: recording and video.
        log: log every tick, for wbc plot, diff and replay, Foxglove and PlotJuggler.
        json: write the report as JSON.
    """

    recording: RecordingOptions
    log: LogFile | None = None
    json: OutputFile | None = None

    def numbered(self, number: int) -> OutputOptions:
        """Return the options for a run of a number: later files do not replace the first ones.

        Args:
            number: number of the run, counted from 1; its files end with it, from 2 on.
        """
        if number == 1:
            return self

        def renamed(path: Path | None) -> Path | None:
            return path and path.with_stem(f"{path.stem}_{number}")

        recording = replace(
            self.recording, html=renamed(self.recording.html), video=renamed(self.recording.video)
        )
        return OutputOptions(recording, log=renamed(self.log), json=renamed(self.json))


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
        self._html, self._video = options.recording.html, options.recording.renderer()
        self._recording = Recording(robot, boxes=boxes)

    def open_observers(self, stack: contextlib.ExitStack) -> list[Observer]:
        """Open the requested log, which is completed when the stack unwinds; add the recording.

        Raises:
            WbcError: the log cannot be written.
        """
        observers: list[Observer] = []
        if self._options.log is not None:
            observers.append(stack.enter_context(FlightRecorder(self._options.log, self._robot)))
        if self._html is not None or self._video is not None:
            observers.append(self._recording)
        return observers

    def write(self, report: Report) -> None:
        """Write the files that are made after the run, and print the paths of all files.

        Raises:
            OutputError: a file cannot be written.
        """
        with contextlib.ExitStack() as stack:
            # Each file is written even if another cannot be.
            stack.callback(write_recording, self._recording, self._html, self._video)
            if any((self._options.log, self._options.json, self._html, self._video)):
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
            print(f"video: {render_video(video, recording).resolve()}")


def render_video(video: Video, recording: Recording) -> Path:
    """Render a video of a recording, and show the progress; return its path.

    Raises:
        WbcError: it cannot be rendered.
    """
    with ProgressBar(f"rendering {video.path.name}") as bar:
        return video.render(recording, lambda done, frames: bar.show(done / frames))
