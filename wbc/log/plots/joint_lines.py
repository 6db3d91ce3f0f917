"""Draws a quantity of the joints in which it is largest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from wbc.log.plots.style import broken_time, legend, thin
from wbc.log.run import LoggedRun

SHOWN = 6  # joints drawn over time


def sustained(values: np.ndarray) -> np.ndarray:
    """Return what each joint exceeds in one of 200 ticks: no single spike ranks it.

    Args:
        values: Magnitudes, shape (n, na); NaN counts as zero.
    """
    found: np.ndarray = np.percentile(np.nan_to_num(values), 99.5, axis=0)
    return found


def largest_joints(values: np.ndarray, count: int = SHOWN) -> np.ndarray:
    """Return the indices of the joints in which magnitudes are largest, the largest first."""
    order: np.ndarray = np.argsort(-sustained(values), kind="stable")[:count]
    return order


def draw_joint_lines(
    axes: Any,
    run: LoggedRun,
    values: np.ndarray,
    label: Callable[[int], str] | None = None,
) -> None:
    """Draw the values of the joints in which they are largest over time.

    Args:
        axes: Matplotlib axes to draw into.
        run: Logged run.
        values: Values, shape (n, na).
        label: Returns the legend's text for the index of a joint; its name by default.
    """
    every = thin(len(run))
    for rank, joint in enumerate(largest_joints(np.abs(values))):
        axes.plot(
            broken_time(run, every),
            values[every, joint],
            color=f"C{rank}",
            linewidth=0.8,
            label=run.robot_info.joints[joint] if label is None else label(int(joint)),
        )
    axes.set(xlabel="time, s")
    legend(axes)
