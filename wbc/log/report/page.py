"""The page of a run's report: everything in one file."""

from __future__ import annotations

import base64
import importlib.util
import io
from collections.abc import Callable
from pathlib import Path

from wbc.atomic_file import replacing
from wbc.errors import MissingExtra
from wbc.log.errors import LogError
from wbc.log.event_rows import EVENT_COLUMNS, event_rows
from wbc.log.plots.standard import STANDARD, draw, require_matplotlib
from wbc.log.plots.style import style
from wbc.log.report.key_figures import key_figures
from wbc.log.run import LoggedRun

_HERE = Path(__file__).parent
_MOST_EVENTS = 500  # listed
_DPI = 130
#: Titles of the plots, by the names of their layouts.
_TITLES = {
    "above": "From above",
    "balance": "Balance",
    "forces": "Contact forces",
    "torques": "Torques",
    "joints": "Joints",
    "timing": "Tick times",
}


def require_jinja2() -> None:
    """Check that the packages of a report are installed, without importing them.

    Raises:
        MissingExtra: One of them is not installed.
    """
    require_matplotlib()
    if importlib.util.find_spec("jinja2") is None:
        raise MissingExtra("jinja2", "report")


def report_page(
    run: LoggedRun,
    film: bytes | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> str:
    """Return a page with figures, plots, events, parameters and conditions of a run.

    Args:
        run: Logged run.
        film: MP4 file of the run to show.
        progress: Called with the share that is done, 0 to 1.

    Raises:
        MissingExtra: `matplotlib` or `jinja2` is not installed.
        LogError: The log lacks a quantity of the plots.
    """
    require_jinja2()
    from jinja2 import Environment, FileSystemLoader

    plots = []
    with style() as figure_class:
        for done, layout in enumerate(STANDARD, 1):
            picture = io.BytesIO()
            draw(run, layout, figure_class).savefig(picture, format="png", dpi=_DPI)
            plots.append((layout.name, _TITLES[layout.name], _encoded(picture.getvalue())))
            progress(done / len(STANDARD))
    rows = event_rows(run.events)
    tables = dict(run.log.tables)
    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    page: str = environment.get_template("report.html").render(
        title=run.title,
        robot=run.robot_info,
        file=run.log.path.name,
        span="" if run.log.span.whole else str(run.log.span),
        survived=tables.get("report", {}).get("survived"),
        reason=tables.get("report", {}).get("fell_why", ""),
        gaps=[str(gap) for gap in run.log.gaps],
        conditions=tables.pop("run", {}),
        loop=tables.get("report", {}).get("loop_conditions", ""),
        figures=key_figures(run),
        plots=plots,
        film=None if film is None else _encoded(film),
        columns=EVENT_COLUMNS,
        events=rows[:_MOST_EVENTS],
        more_events=max(len(rows) - _MOST_EVENTS, 0),
        tables=tables,
        style=(_HERE / "report.css").read_text("utf-8"),
    )
    return page


def save_report(
    run: LoggedRun,
    path: Path,
    film: bytes | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Path:
    """Write the page of a run; see `report_page`. The file stays what it was if that fails.

    Raises:
        LogError: The file cannot be written, or see `report_page`.
        MissingExtra: See `report_page`.
    """
    page = report_page(run, film, progress)
    try:
        with replacing(path) as file:
            file.write_text(page, "utf-8")
    except OSError as error:
        raise LogError(
            f"cannot write the report to {path}: {error.strerror}; give another path"
        ) from error
    return path


def _encoded(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
