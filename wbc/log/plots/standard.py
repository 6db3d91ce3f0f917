"""Draws the standard plots of a run in one call."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wbc.errors import MissingExtra
from wbc.log.errors import LogError
from wbc.log.plots.balance import draw_coordinate, draw_dcm_error
from wbc.log.plots.quantity import draw_quantity
from wbc.log.plots.style import style
from wbc.log.plots.timing import draw_tick_time
from wbc.log.plots.top_view import draw_top_view
from wbc.log.plots.torques import draw_torque_peaks, draw_torques
from wbc.log.run import LoggedRun

KINDS = (".png", ".pdf", ".svg")


def plot(
    run: LoggedRun, folder: str | Path, kind: str = ".png", quantities: Sequence[str] = ()
) -> list[Path]:
    """Draw the standard plots of a run, or any of its quantities.

    The standard plots are `above`: CoM, DCM and ZMP with the footsteps, from above; `balance`: the
    same over time, with the DCM error; `torques`: torques and limits; `timing`: tick times.

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
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtra("matplotlib", "plots")
    folder = Path(folder)
    with style() as figure_of:
        if quantities:
            figures = {name: _quantity_figure(figure_of, run, name) for name in quantities}
        else:
            figures = _standard_figures(figure_of, run)
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


def _quantity_figure(figure_of: Any, run: LoggedRun, name: str) -> Any:
    figure = figure_of(figsize=(11.0, 4.2), layout="constrained")
    draw_quantity(figure.subplots(), run, name)
    return figure


def _standard_figures(figure_of: Any, run: LoggedRun) -> dict[str, Any]:
    figures = {}
    figure = figure_of(figsize=(11.0, 6.2), layout="constrained")
    draw_top_view(figure.subplots(), run)
    figures["above"] = figure

    figure = figure_of(figsize=(11.0, 8.0), layout="constrained")
    rows = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
    draw_coordinate(rows[0], run, 0)
    draw_coordinate(rows[1], run, 1)
    draw_dcm_error(rows[2], run)
    rows[1].get_legend().remove()
    rows[2].set_xlabel("time, s")
    figures["balance"] = figure

    figure = figure_of(figsize=(11.0, 9.0), layout="constrained")
    rows = figure.subplots(2, 1, height_ratios=(2, 3))
    draw_torques(rows[0], run)
    rows[0].set_xlabel("time, s")
    draw_torque_peaks(rows[1], run)
    figures["torques"] = figure

    figure = figure_of(figsize=(11.0, 4.2), layout="constrained")
    draw_tick_time(figure.subplots(), run)
    figures["timing"] = figure
    return figures
