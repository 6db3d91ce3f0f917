"""Plots of the results of a grid: the polar push map, and survival against size."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wbc.errors import MissingExtra
from wbc.log.plots.style import FAINT, LIMIT, style
from wbc.trials.disturbance import direction_name
from wbc.trials.errors import ResultsError
from wbc.trials.results import Results
from wbc.trials.survival import REQUIRED_SHARE, Case, Survival, survival_rates

_COLOURS = ("#1f66c1", "#d1650c", "#0a8f6c", "#7b3fbf", "#c0392b", "#23272f")
_COLUMNS = 4  # of push maps
_MAP_SIZE = 3.1  # inches
_PANEL = 2.9, 1.9  # inches, of survival against size


def plot_results(results: Results, folder: str | Path, stem: str, kind: str = ".png") -> list[Path]:
    """Draw the push map and the survival rates of a grid.

    Args:
        results: the results.
        folder: folder of the plots.
        stem: beginning of the file names.
        kind: file name extension: ".png", ".pdf" or ".svg".

    Returns:
        The paths of the plots.

    Raises:
        MissingExtra: `matplotlib` is not installed.
        ResultsError: there are no trials, or a plot cannot be written.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtra("matplotlib", "plots")
    rates = survival_rates(results.trials)
    if not rates:
        raise ResultsError(f"'{results.grid.name}' has no trials to plot")
    folder = Path(folder)
    draw = {"push_map": _push_maps, "survival": _survival_curves}
    paths = []
    with style() as figure_of:
        for name, function in draw.items():
            figure = function(figure_of, results, rates)
            path = folder / f"{stem}_{name}{kind}"
            try:
                folder.mkdir(parents=True, exist_ok=True)
                figure.savefig(path)
            except OSError as error:
                raise ResultsError(f"cannot write {path}: {error.strerror}") from error
            paths.append(path)
    return paths


def _push_maps(figure_of: Any, results: Results, rates: Sequence[Survival]) -> Any:
    """Draw the largest size that is survived over the direction, forward upward."""
    from matplotlib.ticker import MaxNLocator

    panels = _by_panel(rates)
    columns = min(_COLUMNS, len(panels))
    lines = math.ceil(len(panels) / columns)
    # Height of the suptitle and, below, of the legend.
    size = (max(_MAP_SIZE * columns, 4.6), _MAP_SIZE * lines + 0.8)
    figure = figure_of(figsize=size, layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False, subplot_kw={"projection": "polar"})
    controllers = _controllers(rates)
    largest = max(rate.size for one in rates for rate in one.rates)
    for place in axes.flat[len(panels) :]:
        place.set_visible(False)
    for place, (title, ones) in zip(axes.flat, panels.items(), strict=False):
        place.set_theta_zero_location("N")
        place.set_title(title, pad=14.0, fontsize=9)
        place.set_ylim(0.0, 1.05 * largest)
        place.tick_params(labelsize=7)
        place.set_rlabel_position(45.0)
        place.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
        place.set_xticks(np.radians([0, 90, 180, 270]), ["forward", "left", "back", "right"])
        for controller, colour in controllers.items():
            mine = sorted((o for o in ones if o.case.controller == controller), key=_direction)
            if mine:
                _draw_map(place, mine, colour, rates_too=len(controllers) == 1)
    handles = [_line(colour, name) for name, colour in controllers.items()]
    if len(controllers) == 1:
        handles.append(_line(LIMIT, "falls, the paler the rarer", linestyle=""))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    gap = " " if columns > 2 else "\n"
    figure.suptitle(
        f"{results.grid.name}: largest {_what(results)}, survived in ≥ "
        f"{100 * REQUIRED_SHARE:.0f} %{gap}of {_samples(results)}, as all smaller ones\n",
        fontsize=10,
    )
    return figure


def _draw_map(axes: Any, ones: Sequence[Survival], colour: str, rates_too: bool) -> None:
    """Draw one controller's map; with the rate of every size as a dot, red where it falls."""
    angles = [math.radians(one.direction) for one in ones]
    radii = [one.largest_survived() for one in ones]
    axes.plot([*angles, angles[0]], [*radii, radii[0]], color=colour, marker="o", markersize=3)
    axes.fill([*angles, angles[0]], [*radii, radii[0]], color=colour, alpha=0.12, linewidth=0)
    if not rates_too:
        return
    for angle, one in zip(angles, ones, strict=True):
        for rate in one.rates:
            if rate.share < 1.0:
                alpha = 0.15 + 0.85 * (1.0 - rate.share)
                axes.plot(angle, rate.size, "o", color=LIMIT, alpha=alpha, markersize=3.5)


def _survival_curves(figure_of: Any, results: Results, rates: Sequence[Survival]) -> Any:
    """Draw the survival rate over the size with its confidence interval."""
    panels = _by_panel(rates)
    directions = sorted({one.direction for one in rates})
    width, height = _PANEL
    size = (max(width * len(directions), 5.0) + 0.4, height * len(panels) + 1.1)
    figure = figure_of(figsize=size, layout="constrained")
    axes = figure.subplots(len(panels), len(directions), sharey=True, squeeze=False)
    controllers = _controllers(rates)
    for line, (title, ones) in zip(axes, panels.items(), strict=True):
        line[0].set_ylabel("survived, %")
        for place, direction in zip(line, directions, strict=True):
            place.set_ylim(-4.0, 104.0)
            place.set_yticks([0, 25, 50, 75, 100])
            place.axhline(100 * REQUIRED_SHARE, color=FAINT, linewidth=0.8, linestyle="--")
            place.set_title(f"{title}, {direction_name(direction)}", fontsize=8.5)
            for one in ones:
                if one.direction == direction:
                    _draw_curve(place, one, controllers[one.case.controller])
    for place in axes[-1]:
        place.set_xlabel(_what(results))
    handles = [_line(colour, name) for name, colour in controllers.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    figure.suptitle(
        f"{results.grid.name}: survival rate over {_samples(results)}, with its 95 % confidence "
        "interval",
        fontsize=10,
    )
    return figure


def _draw_curve(axes: Any, one: Survival, colour: str) -> None:
    sizes = [rate.size for rate in one.rates]
    low, high = np.array([rate.interval() for rate in one.rates]).T
    axes.plot(sizes, [100 * r.share for r in one.rates], color=colour, marker="o", markersize=3)
    if len(sizes) > 1:
        axes.fill_between(sizes, 100 * low, 100 * high, color=colour, alpha=0.15, linewidth=0)
    else:
        axes.vlines(sizes, 100 * low, 100 * high, color=colour, alpha=0.4)


def _by_panel(rates: Sequence[Survival]) -> dict[str, list[Survival]]:
    """Return what is drawn in one panel: cases that differ by the controller alone."""
    conditions = {one.case.condition for one in rates}
    panels: dict[str, list[Survival]] = {}
    for one in rates:
        panels.setdefault(_title(one.case, len(conditions) > 1), []).append(one)
    return panels


def _title(case: Case, with_condition: bool) -> str:
    robot = Path(case.robot).stem if case.robot.endswith((".urdf", ".toml")) else case.robot
    return f"{robot}, {case.motion}" + (f", {case.condition}" if with_condition else "")


def _controllers(rates: Sequence[Survival]) -> dict[str, str]:
    """Return the colour of each controller."""
    names = dict.fromkeys(one.case.controller for one in rates)
    return {name: _COLOURS[i % len(_COLOURS)] for i, name in enumerate(names)}


def _line(colour: str, name: str, linestyle: str = "-") -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=colour, linestyle=linestyle, marker="o", markersize=3, label=name)


def _direction(one: Survival) -> float:
    return one.direction


def _what(results: Results) -> str:
    disturbance = results.grid.disturbance
    return f"{disturbance.kind}, {disturbance.unit}"


def _samples(results: Results) -> str:
    phases, seeds = results.grid.phases, len(results.grid.seeds)
    return f"{phases} phases × {seeds} seed{'s' if seeds > 1 else ''}"
