"""Plots of balance: CoM, DCM, ZMP and CoP with the stance soles, over time and from above."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from wbc.geometry.planar import Placement, ground_point
from wbc.geometry.polygon import sole_corners
from wbc.log.plots.style import (
    COM,
    COP,
    DCM,
    REFERENCE,
    ZMP,
    broken_time,
    foot_colours,
    legend,
    mark_events,
    mark_level,
    shade_phases,
    spans,
    thin,
)
from wbc.log.run import LoggedRun

_MIN_LOAD = 0.05  # smallest load of a sole in contact, as a share of the weight
_SHORTEST = 0.05  # s; shorter contacts are not counted as footsteps
_MARGIN = 0.12  # m
_WIDTH, _LEGEND_WIDTH, _TITLES_HEIGHT = 11.0, 2.0, 1.0  # inches
_FLATTEST, _NARROWEST = 0.35, 0.45  # height over width, width over height, of the drawn area
_MIN_STRETCH = 2.0  # of one axis, below which both have one scale


class Curve(NamedTuple):
    """The style in which a point of the robot is drawn."""

    quantity: str
    label: str
    colour: str
    width: float


CURVES = (
    Curve("cop", "CoP, measured", COP, 0.6),
    Curve("zmp", "ZMP, commanded", ZMP, 0.8),
    Curve("dcm_reference", "DCM reference", REFERENCE, 1.6),
    Curve("dcm", "DCM", DCM, 0.9),
    Curve("com", "CoM", COM, 1.2),
)


class StancePeriod(NamedTuple):
    """A period in which a sole is in contact with the ground.

    Attributes:
        side: Side of the sole, e.g. "left".
        colour: Colour of the side.
        pose: Pose of the sole in the middle of the period: position, m, quaternion x y z w.
        half_size: Half length and half width of the sole, m.
        ticks: First tick of the period, and the first one after it.
    """

    side: str
    colour: str
    pose: np.ndarray
    half_size: tuple[float, float]
    ticks: tuple[int, int]


def stance_periods(run: LoggedRun) -> Iterator[StancePeriod]:
    """Yield every stance period of each sole in order of time, the left ones first."""
    least = _MIN_LOAD * run.robot_info.weight
    for (side, colour), half_size in zip(foot_colours(run), run.robot_info.soles, strict=True):
        pose = f"sole_pose/{side}_sole"
        wrenches = (f"foot_wrench/{side}_sole", f"commanded_wrench/{side}_sole")
        known = [n for n in wrenches if n in run and np.isfinite(run[n]).any()]
        if known and pose in run:
            for start, stop in spans(np.nan_to_num(run[known[0]][:, 2]) > least):
                middle = run[pose][(start + stop) // 2]
                yield StancePeriod(side, colour, middle, half_size, (start, stop))


def draw_coordinate(axes: Any, run: LoggedRun, coordinate: int) -> None:
    """Draw x or y of CoM, DCM, ZMP and the stance soles over time.

    Args:
        axes: Matplotlib axes to draw into.
        run: Logged run.
        coordinate: 0 for x, 1 for y.
    """
    for stance in stance_periods(run):
        start, stop = stance.ticks
        middle, half = stance.pose[coordinate], stance.half_size[coordinate]
        axes.fill_between(
            run.time[[start, stop - 1]], middle - half, middle + half, color=stance.colour,
            alpha=0.12, linewidth=0,
        )  # fmt: skip
    every = thin(len(run))
    for curve, points in _known_curves(run):
        values = points[every, coordinate]
        axes.plot(
            broken_time(run, every),
            values,
            color=curve.colour,
            linewidth=curve.width,
            label=curve.label,
        )
    mark_events(axes, run)
    axes.set(ylabel="xy"[coordinate] + ", m")
    axes.set_title("xy"[coordinate] + " of CoM, DCM and ZMP; bands: stance soles")


def draw_dcm_error(axes: Any, run: LoggedRun) -> None:
    """Draw the distance of the DCM from its reference over time, with the phases shaded."""
    every = thin(len(run))
    error = 1e3 * run["dcm_error"]
    shade_phases(axes, run)
    mark_events(axes, run)
    axes.plot(broken_time(run, every), error[every], color=DCM, linewidth=0.9)
    known = error[np.isfinite(error)]
    if known.size:
        rms = float(np.sqrt(np.mean(known**2)))
        mark_level(axes, rms, f"rms {rms:.1f} mm")
        axes.set_ylim(0.0, max(1.1 * float(known.max()), 1e-3))
    axes.set(ylabel="mm", xlabel="time, s")
    axes.set_title("DCM error; shaded: left stance, right stance")


def draw_top_view(axes: Any, run: LoggedRun) -> None:
    """Draw CoM, DCM, ZMP and the footsteps in the horizontal plane."""
    colours = dict(foot_colours(run))
    for side, corners in footprints(run):
        colour = colours[side]
        axes.fill(*corners.T, facecolor=colour, alpha=0.10, linewidth=0)
        axes.plot(*np.vstack([corners, corners[:1]]).T, color=colour, linewidth=0.8, alpha=0.8)
    every = thin(len(run))
    times = broken_time(run, every)
    for curve, points in _known_curves(run):
        if curve.quantity != "dcm_reference":
            line = np.where(np.isfinite(times)[:, None], points[every, :2], np.nan).T
            axes.plot(*line, color=curve.colour, linewidth=curve.width, label=curve.label)
    com = run["com"]
    axes.plot(*com[0, :2], "o", color=COM, markersize=4, label="start")
    axes.plot(*com[-1, :2], "s", color=COM, markersize=4, label="end")
    for side, colour in colours.items():
        label = f"{side.replace('_', ' ')} sole"
        axes.fill([], [], facecolor=colour, alpha=0.2, edgecolor=colour, label=label)
    axes.margins(_MARGIN)
    axes.set(xlabel="x, m", ylabel="y, m")
    _fill_area(axes)
    legend(axes)


def _fill_area(axes: Any) -> None:
    """Draw x and y to one scale if that uses the area, else stretch the shorter one."""
    width, height = (float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim()))
    box = axes.get_window_extent()
    stretch = (width / box.width) / (height / box.height)
    title = "CoM, DCM, ZMP and footsteps, from above"
    if max(stretch, 1.0 / stretch) < _MIN_STRETCH:
        axes.set_aspect("equal", adjustable="datalim")
    else:
        longer, shorter = ("x", "y") if stretch > 1.0 else ("y", "x")
        ratio = max(stretch, 1.0 / stretch)
        title += f"; {shorter} is drawn {ratio:.1f} times as large as {longer}"
    axes.set_title(title)


def top_view_size(run: LoggedRun) -> tuple[float, float]:
    """Return width and height, inches, in which the view from above uses its area."""
    corners = [corners for _, corners in footprints(run)]
    points = np.vstack([run["com"][:, :2], *corners])
    points = points[np.isfinite(points).all(axis=1)]
    width, height = np.ptp(points, axis=0) + 1e-3 if len(points) else (1.0, 1.0)
    ratio = min(max(float(height / width), _FLATTEST), 1.0)
    # A path along y is as high as the page allows, and needs less width beside its legend.
    narrow = min(1.0, float(width / height))
    across = (_WIDTH - _LEGEND_WIDTH) * max(narrow, _NARROWEST)
    return across + _LEGEND_WIDTH, (_WIDTH - _LEGEND_WIDTH) * ratio + _TITLES_HEIGHT


def footprints(run: LoggedRun) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the side and the corners, shape (4, 2), m, world axes, of every footstep made."""
    dt = float(np.median(np.diff(run.time))) if len(run) > 1 else 0.0
    for stance in stance_periods(run):
        ticks = stance.ticks[1] - stance.ticks[0]
        if ticks * dt >= _SHORTEST or ticks == len(run):
            x, y, z, w = stance.pose[3:]
            yaw = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
            placement = Placement(ground_point(stance.pose), yaw)
            corners = sole_corners(placement, *stance.half_size)
            yield stance.side, np.array([[corner.real, corner.imag] for corner in corners])


def _known_curves(run: LoggedRun) -> Iterator[tuple[Curve, np.ndarray]]:
    for curve in CURVES:
        if curve.quantity in run and np.isfinite(run[curve.quantity]).any():
            yield curve, run[curve.quantity]
