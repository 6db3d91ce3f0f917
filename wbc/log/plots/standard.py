"""Draws the standard plots of a run in one call."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from wbc.errors import MissingExtra
from wbc.log.errors import LogError
from wbc.log.plots.balance import (
    draw_coordinate,
    draw_dcm_error,
    draw_top_view,
    top_view_size,
)
from wbc.log.plots.forces import draw_friction, draw_normal_forces
from wbc.log.plots.joints import draw_power, draw_tracking, draw_velocities
from wbc.log.plots.quantity import draw_quantity
from wbc.log.plots.style import legend, style
from wbc.log.plots.timing import draw_tick_time
from wbc.log.plots.torques import draw_torque_peaks, draw_torques
from wbc.log.run import LoggedRun

KINDS = (".png", ".pdf", ".svg")


@dataclass(frozen=True)
class Layout:
    """A figure: panels one above the other.

    Attributes:
        name: Name of the figure, which becomes a part of the file's name.
        size: Width and height, inches, or a function that returns them for a run.
        panels: Functions that draw a run into axes, from top to bottom.
        heights: Relative heights of the panels.
        share_time: Whether the panels share the axis of time.
    """

    name: str
    size: tuple[float, float] | Callable[[LoggedRun], tuple[float, float]]
    panels: tuple[Callable[[Any, LoggedRun], None], ...]
    heights: tuple[float, ...] = (1.0,)
    share_time: bool = False


def _draw_x(axes: Any, run: LoggedRun) -> None:
    draw_coordinate(axes, run, 0)
    legend(axes)


def _draw_y(axes: Any, run: LoggedRun) -> None:
    draw_coordinate(axes, run, 1)


#: The standard plots.
STANDARD = (
    Layout("above", top_view_size, (draw_top_view,)),
    Layout("balance", (11.0, 8.0), (_draw_x, _draw_y, draw_dcm_error), (3.0, 3.0, 2.0), True),
    Layout("forces", (11.0, 6.0), (draw_normal_forces, draw_friction), (3.0, 2.0), True),
    Layout("torques", (11.0, 9.0), (draw_torques, draw_torque_peaks), (2.0, 3.0)),
    Layout("joints", (11.0, 9.0), (draw_tracking, draw_velocities, draw_power), (1.0,) * 3, True),
    Layout("timing", (11.0, 4.2), (draw_tick_time,)),
)


def draw(run: LoggedRun, layout: Layout, figure_class: Any) -> Any:
    """Return a figure of a run.

    Args:
        run: Logged run.
        layout: What to draw.
        figure_class: Class of the figure, see `wbc.log.plots.style.style`.

    Raises:
        LogError: The log does not have a quantity of it.
    """
    size = layout.size(run) if callable(layout.size) else layout.size
    figure = figure_class(figsize=size, layout="constrained")
    rows = figure.subplots(
        len(layout.panels), sharex=layout.share_time, height_ratios=layout.heights, squeeze=False
    )
    for axes, panel in zip(rows[:, 0], layout.panels, strict=True):
        panel(axes, run)
        if layout.share_time and axes is not rows[-1, 0]:
            axes.set(xlabel=None)
    return figure


def require_matplotlib() -> None:
    """Check that Matplotlib is installed, without importing it.

    Raises:
        MissingExtra: It is not installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtra("matplotlib", "plots")


def plot(
    run: LoggedRun, folder: str | Path, kind: str = ".png", quantities: Sequence[str] = ()
) -> list[Path]:
    """Draw the standard plots of a run, or any of its quantities.

    The standard plots are `above`: CoM, DCM and ZMP with the footsteps, from above; `balance`: the
    same over time, with the DCM error; `forces`: normal forces of the soles, and friction;
    `torques`: torques and limits; `joints`: tracking, velocities and powers; `timing`: tick times.

    Args:
        run: Logged run.
        folder: Folder for the plots.
        kind: File name extension: ".png", ".pdf" or ".svg".
        quantities: Names of quantities to draw instead of the standard plots, see
            `LoggedRun.quantities`.

    Returns:
        The paths of the plots.

    Raises:
        MissingExtra: `matplotlib` is not installed.
        LogError: A plot cannot be written, or the log has no such quantity.
    """
    require_matplotlib()
    folder = Path(folder)
    with style() as figure_class:
        layouts = [quantity_layout(name) for name in quantities] or STANDARD
        figures = {layout.name: draw(run, layout, figure_class) for layout in layouts}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            paths = []
            for name, figure in figures.items():
                figure.suptitle(f"{run.log.path.name}: {run.title}", x=0.01, ha="left", fontsize=11)
                path = folder / f"{run.log.path.stem}_{name.replace('/', '_')}{kind}"
                figure.savefig(path)
                paths.append(path)
        except OSError as error:
            raise LogError(
                f"cannot write the plots to {folder}: {error.strerror}; give another folder"
            ) from error
    return paths


def quantity_layout(name: str) -> Layout:
    """Return the layout of a quantity over time."""
    return Layout(name, (11.0, 4.2), (partial(draw_quantity, name=name),))
