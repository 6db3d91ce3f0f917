"""Plots of joint torques relative to their limits."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.joint_lines import draw_joint_lines, largest_joints
from wbc.log.plots.style import FAINT, LIMIT, mark_events
from wbc.log.run import LoggedRun

_LISTED = 34  # joints listed


def draw_torques(axes: Any, run: LoggedRun) -> None:
    """Draw the torques closest to their limits over time, as percentages of the limits."""
    share, limits = shares(run), run.robot_info.tau_max
    draw_joint_lines(
        axes, run, share, lambda joint: f"{run.robot_info.joints[joint]} ({limits[joint]:g})"
    )
    mark_events(axes, run)
    axes.axhline(100.0, color=LIMIT, linewidth=1.0)
    axes.set_ylim(0.0, max(108.0, 1.05 * float(share.max(initial=0.0))))
    axes.set(ylabel="% of the limit")
    axes.set_title(
        "Torques of the six joints closest to their limits (N·m; N for prismatic joints)"
    )


def draw_torque_peaks(axes: Any, run: LoggedRun) -> None:
    """Draw the median and peak torque of every joint, in percent of its limit."""
    share = shares(run)
    order = largest_joints(share, _LISTED)[::-1]
    peak, middle = share.max(axis=0), np.median(share, axis=0)
    places = np.arange(len(order))
    colours = [LIMIT if peak[j] >= 99.9 else "#2f6fb0" for j in order]
    axes.barh(places, peak[order], color=colours, alpha=0.35, height=0.7, label="peak")
    axes.barh(places, middle[order], color=colours, height=0.7, label="median")
    axes.axvline(100.0, color=LIMIT, linewidth=1.0)
    axes.set_yticks(places, [run.robot_info.joints[j] for j in order], fontsize=7)
    axes.set_ylim(-0.6, len(order) - 0.4)
    axes.set_xlim(0.0, max(108.0, 1.05 * float(peak.max(initial=0.0))))
    axes.grid(axis="y", visible=False)
    axes.set(xlabel="% of the limit")
    axes.set_title("Torque of every joint: median (full), peak (faded)")
    axes.tick_params(axis="y", colors=FAINT, labelcolor="black", length=0)


def shares(run: LoggedRun) -> np.ndarray:
    """Return |torque| in percent of its limit, shape (n, na)."""
    found: np.ndarray = 100.0 * np.abs(np.nan_to_num(run["tau"])) / run.robot_info.tau_max
    return found
