"""`wbc replay`: replay a log in the browser, or write a page or a video of it."""

from __future__ import annotations

import argparse
import webbrowser
from typing import Any

from wbc.cli.output import OutputError
from wbc.cli.parser import output_file
from wbc.cli.progress import RenderingProgress
from wbc.errors import WbcError
from wbc.log.logged_robot import logged_robot
from wbc.log.run import LoggedRun
from wbc.view import Recording, Replay, TimeSeries
from wbc.view.timeline import record
from wbc.view.video import Video


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "replay",
        help="replay a log in the browser, or write a video of it",
        description="Shows a log in the browser with a timeline, until Ctrl-C. Space plays and "
        "pauses, the arrow keys step by 20 ms, with Shift by 1 s.",
    )
    parser.add_argument(
        "log", metavar="LOG", help="path of a log, see --log of the other subcommands"
    )
    parser.add_argument(
        "--robot",
        metavar="NAME|FILE",
        help="the robot, if it cannot be found by its name in the log",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument(
        "--port",
        type=int,
        metavar="N",
        help="port of the page (default: the first free one from 7000 on)",
    )
    parser.add_argument(
        "--html", type=output_file, metavar="FILE", help="write a page that plays offline, and exit"
    )
    parser.add_argument(
        "--video", type=output_file, metavar="FILE.mp4", help="write a video, and exit"
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Replay; return the exit code."""
    video = Video(options.video) if options.video is not None else None
    run = LoggedRun.read(options.log)
    robot = logged_robot(run.robot_info, options.robot)
    boxes = run.log.boxes()
    if options.html is not None or video is not None:
        recording = Recording(robot, boxes=boxes)
        record(run, recording)
        try:
            if options.html is not None:
                print(f"recording: {recording.save(options.html).resolve()}")
            if video is not None:
                with RenderingProgress() as progress:
                    path = video.render(recording, progress.show)
                print(f"video: {path.resolve()}")
        except WbcError as error:
            raise OutputError(str(error)) from error
        return 0
    replay = Replay(robot, run, port=options.port, boxes=boxes, series=_series(run))

    def ready(url: str) -> None:
        print(f"{run.title}\nReplay: {url}\nPress Ctrl-C to stop.", flush=True)
        if options.open:
            webbrowser.open(url)

    replay.serve(ready)
    return 0


def _series(run: LoggedRun) -> list[TimeSeries]:
    return [
        TimeSeries("DCM error, mm", run.time, 1e3 * run["dcm_error"]),
        TimeSeries("controller, µs", run.time, 1e6 * run["controller_time"]),
    ]
