"""Plots of the contact forces of the feet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from wbc.log.plots.style import (
    broken_time,
    foot_colours,
    legend,
    mark_events,
    mark_level,
    shade_phases,
    thin,
)
from wbc.log.run import LoggedRun

_LOADED = 0.2  # of the weight: below it the ratio of forces says nothing


def _wrenches(run: LoggedRun, source: str) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield side, colour and wrench, shape (n, 6), of each foot of which there is one."""
    for side, colour in foot_colours(run):
        name = f"{source}/{side}_sole"
        if name in run and np.isfinite(run[name]).any():
            yield side, colour, run[name]


def draw_normal_forces(axes: Any, run: LoggedRun) -> None:
    """Draw the normal force on each sole over time, measured and commanded, and the weight."""
    every = thin(len(run))
    times = broken_time(run, every)
    shade_phases(axes, run)
    for side, colour, wrench in _wrenches(run, "foot_wrench"):
        axes.plot(times, wrench[every, 2], color=colour, linewidth=1.0, label=f"{side}, measured")
    for side, colour, wrench in _wrenches(run, "commanded_wrench"):
        axes.plot(
            times, wrench[every, 2], color=colour, linewidth=0.7, linestyle="--",
            label=f"{side}, commanded",
        )  # fmt: skip
    mark_events(axes, run)
    mark_level(axes, run.robot_info.weight, "weight")
    axes.set(ylabel="N")
    axes.set_title("Normal force on the soles; shaded: left stance, right stance")
    if axes.get_legend_handles_labels()[0]:
        legend(axes)


def draw_friction(axes: Any, run: LoggedRun) -> None:
    """Draw tangential over normal force of each loaded sole: the friction that is used."""
    every = thin(len(run))
    times = broken_time(run, every)
    for source, dashes, width in (("foot_wrench", "-", 1.0), ("commanded_wrench", "--", 0.7)):
        for _, colour, wrench in _wrenches(run, source):
            normal = np.where(wrench[:, 2] > _LOADED * run.robot_info.weight, wrench[:, 2], np.nan)
            ratio = np.hypot(wrench[:, 0], wrench[:, 1]) / normal
            axes.plot(times, ratio[every], color=colour, linewidth=width, linestyle=dashes)
    mark_events(axes, run)
    axes.set_ylim(bottom=0.0)
    axes.set(xlabel="time, s", ylabel="tangential / normal")
    axes.set_title(
        f"Friction that is used, of soles that carry {100 * _LOADED:.0f} % of the weight"
    )
