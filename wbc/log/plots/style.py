"""The common style of all plots."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from wbc.log.run import LoggedRun
from wbc.runtime.event import FALL, RESET

COM, DCM, REFERENCE, ZMP, COP = "#23272f", "#7b3fbf", "#b48ad9", "#e69f00", "#0a8f6c"
LEFT, RIGHT = "#1f66c1", "#d1650c"
LIMIT, GRID, FAINT = "#c0392b", "#dfe4ea", "#97a1ac"

_FOUR_FEET = (
    ("front_left", LEFT),
    ("front_right", RIGHT),
    ("hind_left", "#6fa3e0"),
    ("hind_right", "#f0a35e"),
)
_STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.edgecolor": "#8c96a0",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.dpi": 110,
    "savefig.dpi": 150,
}


@contextmanager
def style() -> Iterator[Any]:
    """Apply the style to Matplotlib without opening a window; yield the class `Figure`."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        yield Figure


def foot_colours(run: LoggedRun) -> tuple[tuple[str, str], ...]:
    """Return the side and the colour of each foot, in the order of the robot's soles."""
    quadruped = len(run.robot_info.soles) == len(_FOUR_FEET)
    return _FOUR_FEET if quadruped else (("left", LEFT), ("right", RIGHT))


def legend(axes: Any) -> None:
    """Draw the legend to the right of the axes."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def mark_level(axes: Any, value: float, text: str, colour: str = FAINT) -> None:
    """Draw a horizontal line with a text to the right of the axes."""
    dashes = "--" if colour == FAINT else "-"
    axes.axhline(value, color=colour, linewidth=0.9, linestyle=dashes)
    axes.text(1.005, value, text, transform=axes.get_yaxis_transform(), va="center", fontsize=8)


def shade_phases(axes: Any, run: LoggedRun) -> None:
    """Shade the phases of single support, one colour per stance foot."""
    for number, colour in ((2, LEFT), (3, RIGHT)):
        for start, stop in spans(run["phase"] == number):
            axes.axvspan(run.time[start], run.time[stop - 1], color=colour, alpha=0.07, linewidth=0)


def broken_time(run: LoggedRun, every: slice) -> np.ndarray:
    """Return some of the times, s, with NaN where a run begins: lines are broken at resets."""
    time, tick = run.time[every].copy(), run["tick"][every]
    time[1:][np.diff(tick) < 0.0] = np.nan
    return time


def mark_events(axes: Any, run: LoggedRun) -> None:
    """Mark falls, resets and pushes, and the ticks whose QP had no solution."""
    for event in run.events:
        if event.kind in (FALL, RESET):
            colour, dashes = (LIMIT, "-") if event.kind == FALL else (FAINT, "--")
            axes.axvline(event.time, color=colour, linestyle=dashes, linewidth=1.0)
        elif event.name == "push" and event.outcome == "accepted":
            axes.axvline(event.time, color=ZMP, linestyle=":", linewidth=1.2)
    for start, stop in spans(run["status"] != 0):
        axes.axvspan(run.time[start], run.time[stop - 1], color=LIMIT, alpha=0.35, linewidth=0.8)


def spans(chosen: np.ndarray) -> list[tuple[int, int]]:
    """Return (start, stop) of each sequence of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], chosen, [False]))))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def thin(count: int, most: int = 6000) -> slice:
    """Return a slice that reduces `count` points to at most `most`, for plots of long runs."""
    return slice(None, None, max(1, -(-count // most)))
