"""`wbc replay`: replay a log in the browser, or write a page or a video of it."""

from __future__ import annotations

import webbrowser
from pathlib import Path

from wbc.cli.argument_types import Port, RobotName
from wbc.cli.outputs import RecordingOptions, write_recording
from wbc.cli.progress import ProgressBar
from wbc.log.logged_robot import logged_robot
from wbc.log.timeline import LoggedTimeline
from wbc.runtime.event import FALL, RESET
from wbc.view import Recording, Replay, TimeSeries
from wbc.view.recording import Marker
from wbc.view.timeline import record


def replay(
    log: Path,
    files: RecordingOptions,
    *,
    robot: RobotName | None = None,
    open: bool = False,
    port: Port | None = None,
) -> None:
    """Show a log in the browser with a timeline, until Ctrl-C.

    Space plays and pauses, the arrow keys step by 20 ms, with Shift by 1 s.

    Args:
        log: path of a log, see --log of the other subcommands.
        files: files to write instead of showing a page.
        robot: the robot, if it cannot be found by its name in the log.
        open: open the page in the browser.
        port: port of the page (default: the first free one from 7000 on).
    """
    renderer = files.renderer()
    with ProgressBar(f"reading {log.name}") as bar:
        timeline = LoggedTimeline(log, bar.show)
    run = timeline.overview
    loaded = logged_robot(run.robot_info, robot)
    boxes = run.log.boxes()
    markers = [
        Marker(event.time, event.kind, event.reason)
        for event in run.events
        if event.kind in (FALL, RESET)
    ]
    if files.html is not None or renderer is not None:
        recording = Recording(loaded, boxes=boxes)
        with ProgressBar("recording") as bar:
            record(timeline, recording, bar.show)
        recording.markers = markers
        write_recording(recording, files.html, renderer)
        return

    def ready(url: str) -> None:
        print(f"{run.title}\nReplay: {url}\nPress Ctrl-C to stop.", flush=True)
        if open:
            webbrowser.open(url)

    series = [
        TimeSeries("DCM error, mm", run.time, 1e3 * run["dcm_error"]),
        TimeSeries("controller, µs", run.time, 1e6 * run["controller_time"]),
    ]
    Replay(loaded, timeline, port=port, boxes=boxes, series=series, markers=markers).serve(ready)
