"""Plots of balance over time: DCM and ZMP in x and y, and the DCM error."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.style import (
    COM,
    COP,
    DCM,
    FAINT,
    LEFT,
    REFERENCE,
    RIGHT,
    ZMP,
    mark_failures,
    shade_phases,
    spans,
    thin,
)
from wbc.log.run import LoggedRun


def draw_coordinate(axes: Any, run: LoggedRun, coordinate: int) -> None:
    """Draw x or y of CoM, DCM, ZMP and the stance soles over time.

    Args:
        axes: Matplotlib axes to draw into.
        run: Logged run.
        coordinate: 0 for x, 1 for y.
    """
    every = thin(len(run))
    time = run.time[every]
    _draw_soles(axes, run, coordinate)
    for name, colour, width, label in (
        ("cop", COP, 0.6, "CoP, measured"),
        ("zmp", ZMP, 0.8, "ZMP, commanded"),
        ("dcm_reference", REFERENCE, 1.6, "DCM reference"),
        ("dcm", DCM, 0.9, "DCM"),
        ("com", COM, 1.2, "CoM"),
    ):
        points = run.point(name)[every]
        if np.isfinite(points).any():
            axes.plot(time, points[:, coordinate], color=colour, linewidth=width, label=label)
    mark_failures(axes, run.time, run.state("status"))
    axes.set(ylabel="xy"[coordinate] + ", m")
    axes.set_title("xy"[coordinate] + " of CoM, DCM and ZMP; bands: stance soles")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw_dcm_error(axes: Any, run: LoggedRun) -> None:
    """Draw the distance of the DCM from its reference over time, with the phases shaded."""
    every = thin(len(run))
    error = 1e3 * run.state("dcm_error")
    shade_phases(axes, run.time, run.state("phase"))
    mark_failures(axes, run.time, run.state("status"))
    axes.plot(run.time[every], error[every], color=DCM, linewidth=0.9)
    known = error[np.isfinite(error)]
    if known.size:
        rms = float(np.sqrt(np.mean(known**2)))
        axes.axhline(rms, color=FAINT, linewidth=0.8, linestyle="--")
        axes.set_ylim(0.0, max(1.1 * float(known.max()), 1e-3))
        axes.text(
            1.005, rms, f"rms {rms:.1f} mm", transform=axes.get_yaxis_transform(), va="center"
        )
    axes.set(ylabel="mm")
    axes.set_title("DCM error; shaded: left stance, right stance")


def _draw_soles(axes: Any, run: LoggedRun, coordinate: int) -> None:
    """Draw a band for the extent of each stance sole."""
    least = 0.05 * run.robot_info.weight
    for index, (side, colour) in enumerate((("left", LEFT), ("right", RIGHT))):
        name = f"{side}_sole"
        wrench = run.foot_wrenches.get(name, run.commanded_wrenches.get(name))
        if wrench is None or name not in run.soles:
            continue
        half = run.robot_info.soles[index][coordinate]
        centre = run.soles[name][:, coordinate]
        for start, stop in spans(np.nan_to_num(wrench[:, 2]) > least):
            middle = float(np.median(centre[start:stop]))
            axes.fill_between(
                run.time[[start, stop - 1]],
                middle - half,
                middle + half,
                color=colour,
                alpha=0.12,
                linewidth=0,
            )
