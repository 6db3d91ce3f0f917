"""Plots any quantity of the tick over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.style import broken_time, legend, mark_events, thin
from wbc.log.run import LoggedRun

_LEGEND = 12  # largest number of components with a legend entry each


def draw_quantity(axes: Any, run: LoggedRun, name: str) -> None:
    """Draw all components of a quantity over time.

    Args:
        axes: Matplotlib axes to draw into.
        run: Logged run.
        name: Name of the quantity.

    Raises:
        LogError: The log has no quantity of that name.
    """
    values = run[name].reshape(len(run), -1)
    column = run.quantities[name]
    every = thin(len(run))
    for i in range(values.shape[1]):
        axes.plot(broken_time(run, every), values[every, i], linewidth=0.9, label=column.labels[i])
    mark_events(axes, run)
    axes.set(xlabel="time, s", ylabel=column.unit or None)
    axes.set_title(f"{name}: {column.doc}" + (f" ({column.frame})" if column.frame else ""))
    if 1 < values.shape[1] <= _LEGEND:
        legend(axes)
    if not np.isfinite(values).any():
        axes.text(0.5, 0.5, "unknown in this run", transform=axes.transAxes, ha="center")
