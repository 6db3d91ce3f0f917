"""`wbc report`: a logged run as one page."""

from __future__ import annotations

import tempfile
from pathlib import Path

from wbc.cli.argument_types import OutputFile, RobotName
from wbc.cli.logged_run import SpanOptions, read_run
from wbc.cli.output import writing_results
from wbc.cli.outputs import render_video
from wbc.cli.progress import ProgressBar
from wbc.log.errors import LogError
from wbc.log.logged_robot import logged_robot
from wbc.log.report.page import require_jinja2, save_report
from wbc.log.run import LoggedRun
from wbc.view import Recording, Video
from wbc.view.timeline import record


def report(
    log: Path,
    span: SpanOptions,
    *,
    out: OutputFile | None = None,
    film: bool = False,
    robot: RobotName | None = None,
) -> None:
    """Write a run as one HTML file: figures, plots, events, parameters and conditions.

    The file opens offline, in any browser.

    Args:
        log: path of a log, see --log of the other subcommands.
        span: part of the run.
        out: path of the file (default: that of the log, with the suffix .html).
        film: include a film of the run, which is rendered.
        robot: robot of the film, if it cannot be found by its name in the log.
    """
    require_jinja2()
    with tempfile.TemporaryDirectory(prefix="wbc-report") as folder:
        video = Video(Path(folder) / "film.mp4") if film else None  # fails early without a browser
        run = read_run(log, span.span())
        content = None if video is None else _film(run, video, robot)
        with writing_results(LogError), ProgressBar("drawing the plots") as bar:
            path = save_report(run, out or log.with_suffix(".html"), content, bar.show)
    print(f"report: {path.resolve()}")


def _film(run: LoggedRun, video: Video, robot: str | None) -> bytes:
    recording = Recording(logged_robot(run.robot_info, robot), boxes=run.log.boxes())
    record(run, recording)
    return render_video(video, recording).read_bytes()
