"""`wbc replay`: move through a log in the browser, or make a page or a film of it."""

from __future__ import annotations

import argparse
import webbrowser
from typing import Any

from wbc.cli.parser import output
from wbc.cli.progress import Rendering
from wbc.log.robot import robot_of
from wbc.log.run import LoggedRun
from wbc.view import Recording, Replay, Strip
from wbc.view.film import record
from wbc.view.video import Video


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "replay",
        help="move through a log in the browser, or film it",
        description="Shows a log in the browser, with a slider through all of its time, until "
        "Ctrl-C. Space plays and pauses, the arrow keys step by 20 ms, with Shift by 1 s.",
    )
    parser.add_argument("log", metavar="LOG", help="a log, see --log of the other subcommands")
    parser.add_argument(
        "--robot",
        metavar="NAME|FILE",
        help="the robot, if it is not found by the name that the log says",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument("--port", type=int, metavar="N", help="of the page (default: 7000 or next)")
    parser.add_argument(
        "--html", type=output, metavar="FILE", help="write a page that plays offline, and end"
    )
    parser.add_argument("--video", type=output, metavar="FILE.mp4", help="write a film, and end")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Show; returns the exit code."""
    video = Video(options.video) if options.video is not None else None
    run = LoggedRun.read(options.log)
    robot = robot_of(run.sheet, options.robot)
    boxes = run.log.boxes()
    if options.html is not None or video is not None:
        recording = Recording(robot, boxes=boxes)
        record(run, recording)
        if options.html is not None:
            print(f"recording: {recording.save(options.html).resolve()}")
        if video is not None:
            with Rendering() as rendering:
                path = video.render(recording, rendering.show)
            print(f"video: {path.resolve()}")
        return 0
    replay = Replay(robot, run, port=options.port, boxes=boxes, strips=_strips(run))

    def ready(url: str) -> None:
        print(f"{run.title}\nReplay: {url}\nCtrl-C ends", flush=True)
        if options.open:
            webbrowser.open(url)

    replay.serve(ready)
    return 0


def _strips(run: LoggedRun) -> list[Strip]:
    return [
        Strip("DCM error, mm", run.time, 1e3 * run.state("dcm_error")),
        Strip("controller, µs", run.time, 1e6 * run.state("controller_time")),
    ]
