"""Plot of a walk from above: CoM, DCM, ZMP and footsteps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from wbc.geometry.planar import Placement, ground_point
from wbc.geometry.polygon import sole_corners
from wbc.log.plots.style import COM, COP, DCM, LEFT, RIGHT, ZMP, spans, thin
from wbc.log.run import LoggedRun

_LOADED = 0.05  # smallest load of a sole in contact, as a share of the weight
_SHORTEST = 0.05  # s; shorter contacts are not counted as footsteps
_MARGIN = 0.12  # m


def draw_top_view(axes: Any, run: LoggedRun) -> None:
    """Draw CoM, DCM, ZMP and the footsteps in the horizontal plane."""
    every = thin(len(run))
    for side, corners in footprints(run):
        colour = LEFT if side == "left" else RIGHT
        axes.fill(*corners.T, facecolor=colour, alpha=0.10, linewidth=0)
        axes.plot(*np.vstack([corners, corners[:1]]).T, color=colour, linewidth=0.8, alpha=0.8)
    for name, colour, width, label in (
        ("cop", COP, 0.6, "CoP, measured"),
        ("zmp", ZMP, 0.7, "ZMP, commanded"),
        ("dcm", DCM, 1.0, "DCM"),
        ("com", COM, 1.4, "CoM"),
    ):
        points = run.point(name)[every]
        if np.isfinite(points).any():
            axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=width, label=label)
    com = run.point("com")
    axes.plot(*com[0, :2], "o", color=COM, markersize=4, label="start")
    axes.plot(*com[-1, :2], "s", color=COM, markersize=4, label="end")
    for colour, label in ((LEFT, "left sole"), (RIGHT, "right sole")):
        axes.fill([], [], facecolor=colour, alpha=0.2, edgecolor=colour, label=label)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(_MARGIN)
    axes.set(xlabel="x, m", ylabel="y, m")
    axes.set_title("CoM, DCM, ZMP and footsteps, from above")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def footprints(run: LoggedRun) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the side and the corners, shape (4, 2), m, world axes, of every footstep made."""
    least = _LOADED * run.robot_info.weight
    dt = float(np.median(np.diff(run.time))) if len(run) > 1 else 0.0
    for index, side in enumerate(("left", "right")):
        name = f"{side}_sole"
        if name not in run.soles:
            continue
        wrench = run.foot_wrenches.get(name, run.commanded_wrenches.get(name))
        if wrench is None:
            continue
        length, width = run.robot_info.soles[index]
        for start, stop in spans(np.nan_to_num(wrench[:, 2]) > least):
            if (stop - start) * dt >= _SHORTEST or stop - start == len(run):
                yield side, _corners(run.soles[name][(start + stop) // 2], length, width)


def _corners(pose: np.ndarray, half_length: float, half_width: float) -> np.ndarray:
    x, y, z, w = pose[3:]
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    corners = sole_corners(Placement(ground_point(pose), float(yaw)), half_length, half_width)
    return np.array([[corner.real, corner.imag] for corner in corners])
