"""Plots of the joints' motion: tracking, velocities relative to their limits, and powers."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.log.plots.joint_lines import draw_joint_lines
from wbc.log.plots.style import COM, LIMIT, broken_time, legend, mark_events, thin
from wbc.log.run import LoggedRun

_BASE_V = 6  # entries of v before the joints


def tracking_error(run: LoggedRun) -> np.ndarray:
    """Return measured joint position minus the target of the tick before, rad or m, shape (n, na).

    The target of a tick is the position one period ahead, `q + T v + T² a / 2`. The first tick of
    each run has no error (NaN).
    """
    error = np.full_like(run["q_target"], np.nan)
    error[1:] = run["joint_position"][1:] - run["q_target"][:-1]
    error[1:][np.diff(run["tick"]) != 1.0] = np.nan
    return error


def power(run: LoggedRun) -> np.ndarray:
    """Return the mechanical power `τ q̇` that each motor gives, W, shape (n, na)."""
    found: np.ndarray = run["tau"] * run["v"][:, _BASE_V:]
    return found


def velocity_shares(run: LoggedRun) -> np.ndarray:
    """Return |velocity| in percent of its limit, shape (n, na)."""
    found: np.ndarray = 100.0 * np.abs(run["v"][:, _BASE_V:]) / run.robot_info.v_max
    return found


def draw_tracking(axes: Any, run: LoggedRun) -> None:
    """Draw the deviation of joints from their targets, of those where it is largest."""
    draw_joint_lines(axes, run, 1e3 * tracking_error(run))
    mark_events(axes, run)
    axes.set(ylabel="mrad (mm)")
    axes.set_title("Joint position minus target of the tick before: the six largest")


def draw_velocities(axes: Any, run: LoggedRun) -> None:
    """Draw the joint velocities closest to their limits, in percent of the limits."""
    limits, share = run.robot_info.v_max, velocity_shares(run)
    draw_joint_lines(
        axes, run, share, lambda joint: f"{run.robot_info.joints[joint]} ({limits[joint]:.3g})"
    )
    axes.axhline(100.0, color=LIMIT, linewidth=1.0)
    mark_events(axes, run)
    axes.set_ylim(0.0, max(108.0, 1.05 * float(np.nan_to_num(share).max(initial=0.0))))
    axes.set(ylabel="% of the limit")
    axes.set_title("Velocities of the six joints closest to their limits (rad/s; m/s if prismatic)")


def draw_power(axes: Any, run: LoggedRun) -> None:
    """Draw the mechanical power of all joints together, and of those that give or take most."""
    powers = power(run)
    every = thin(len(run))
    total = powers.sum(axis=1)
    draw_joint_lines(axes, run, powers)
    axes.plot(broken_time(run, every), total[every], color=COM, linewidth=1.0, label="all joints")
    mark_events(axes, run)
    known = total[np.isfinite(total)]
    title = "Mechanical power τ q̇ of the joints"
    if known.size:
        gave = float(np.nan_to_num(np.maximum(powers, 0.0)).sum(axis=1).mean())
        title += f"; motors give {gave:.0f} W on average, peak {float(known.max()):.0f} W"
    axes.set(ylabel="W")
    axes.set_title(title)
    legend(axes)
