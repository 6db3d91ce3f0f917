"""Plot of the computation time per tick: estimator and controller."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.style import FAINT, LIMIT, mark_failures, thin
from wbc.log.run import LoggedRun

_CONTROLLER, _ESTIMATOR = "#2f6fb0", "#8fb8de"


def draw_tick_time(axes: Any, run: LoggedRun) -> None:
    """Draw the computation times of every tick on a logarithmic axis, and the control period."""
    every = thin(len(run), 20_000)
    total = 1e6 * (run.state("estimator_time") + run.state("controller_time"))
    estimator = 1e6 * run.state("estimator_time")
    axes.plot(run.time[every], total[every], ".", color=_CONTROLLER, markersize=1.2)
    axes.plot(run.time[every], estimator[every], ".", color=_ESTIMATOR, markersize=1.0)
    period = 1e6 * float(np.median(np.diff(run.time))) if len(run) > 1 else np.nan
    if np.isfinite(period):
        axes.axhline(period, color=LIMIT, linewidth=1.0)
        _label(axes, period, f"period {period:.0f} µs")
    for share, name in ((50, "median"), (99, "p99")):
        value = float(np.percentile(total, share))
        axes.axhline(value, color=FAINT, linewidth=0.8, linestyle="--")
        _label(axes, value, f"{name} {value:.0f} µs")
    mark_failures(axes, run.time, run.state("status"))
    axes.set_yscale("log")
    axes.set(ylabel="µs", xlabel="time, s")
    failed = int((run.state("status") != 0).sum())
    axes.set_title(
        "Tick time: estimator (light), with controller (dark)"
        + (f"; {failed} ticks without a solution (red)" if failed else "")
    )


def _label(axes: Any, value: float, text: str) -> None:
    axes.text(1.005, value, text, transform=axes.get_yaxis_transform(), va="center", fontsize=8)
