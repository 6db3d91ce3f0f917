"""Plot of the computation time per tick: estimator and controller."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.style import LIMIT, mark_events, mark_level, thin
from wbc.log.run import LoggedRun

_CONTROLLER, _ESTIMATOR = "#2f6fb0", "#8fb8de"


def draw_tick_time(axes: Any, run: LoggedRun) -> None:
    """Draw the computation times of every tick on a logarithmic axis, and the control period."""
    every = thin(len(run), 20_000)
    estimator = 1e6 * run["estimator_time"]
    total = estimator + 1e6 * run["controller_time"]
    axes.plot(run.time[every], total[every], ".", color=_CONTROLLER, markersize=1.2)
    axes.plot(run.time[every], estimator[every], ".", color=_ESTIMATOR, markersize=1.0)
    if len(run) > 1:
        period = 1e6 * float(np.median(np.diff(run.time)))
        mark_level(axes, period, f"budget {period:.0f} µs", LIMIT)
    for share, name in ((50, "median"), (99, "p99")):
        value = float(np.percentile(total, share))
        mark_level(axes, value, f"{name} {value:.0f} µs")
    mark_events(axes, run)
    axes.set_yscale("log")
    axes.set(ylabel="µs", xlabel="time, s")
    failed = int((run["status"] != 0).sum())
    axes.set_title(
        "Controller time (dark), with the estimator (light)"
        + (f"; {failed} ticks without a solution (red)" if failed else "")
    )
