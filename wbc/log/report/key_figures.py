"""The figures that describe a run, computed from its log."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wbc.log.plots.joint_lines import sustained
from wbc.log.plots.joints import power, velocity_shares
from wbc.log.plots.torques import shares
from wbc.log.run import LoggedRun
from wbc.runtime.event import FALL, RESET

_AT_LIMIT = 99.9  # %


@dataclass(frozen=True, slots=True)
class KeyFigure:
    """One figure of a run.

    Attributes:
        name: What it is.
        value: Its value, with the unit.
        note: Further values of it.
        poor: Whether it deserves a second look.
    """

    name: str
    value: str
    note: str = ""
    poor: bool = False


def key_figures(run: LoggedRun) -> list[KeyFigure]:
    """Return the figures of a run, or of the part of it that was read, in order of importance."""
    found = [*_outcome(run), *_balance(run), *_joints(run), *_ticks(run)]
    return found


def _outcome(run: LoggedRun) -> Iterator[KeyFigure]:
    duration = run.end - run.start
    note = f"{len(run)} ticks"
    if duration > 0.0:
        note += f" at {(len(run) - 1) / duration:.0f} Hz"
    yield KeyFigure("duration", f"{duration:.1f} s", note)
    falls = [event for event in run.events if event.kind == FALL]
    resets = sum(event.kind == RESET for event in run.events)
    reason = falls[0].reason if falls else ""
    note = f"first at {falls[0].time:.2f} s: {reason}" if falls else f"{resets} resets"
    yield KeyFigure("falls", str(len(falls)), note, bool(falls))
    steps = int(np.maximum(np.diff(run["steps"]), 0.0).sum())
    com = run["com"][np.isfinite(run["com"]).all(axis=1), :2]
    if len(com):
        forward, left = com[-1] - com[0]
        note = f"CoM: {forward:+.2f} m in x, {left:+.2f} m in y"
        yield KeyFigure("steps", str(steps), note)


def _balance(run: LoggedRun) -> Iterator[KeyFigure]:
    error = 1e3 * run["dcm_error"]
    known = np.isfinite(error)
    if known.any():
        worst = int(np.nanargmax(np.where(known, error, -1.0)))
        yield KeyFigure(
            "DCM error",
            f"{np.sqrt(np.mean(error[known] ** 2)):.1f} mm rms",
            f"largest {error[worst]:.0f} mm at {run.time[worst]:.2f} s",
        )


def _joints(run: LoggedRun) -> Iterator[KeyFigure]:
    for name, values in (("torque", shares(run)), ("velocity", velocity_shares(run))):
        peak = np.nan_to_num(values)
        tick, joint = np.unravel_index(int(np.argmax(peak)), peak.shape)
        worst = float(peak[tick, joint])
        usual = int(np.argmax(sustained(values)))
        yield KeyFigure(
            f"largest joint {name}",
            f"{worst:.0f} % of the limit",
            f"{run.robot_info.joints[int(joint)]} at {run.time[tick]:.2f} s; exceeded in 0.5 % of "
            f"the ticks: {sustained(values)[usual]:.0f} % ({run.robot_info.joints[usual]})",
            worst >= _AT_LIMIT,
        )
    powers = np.nan_to_num(power(run))
    gave = np.maximum(powers, 0.0).sum(axis=1)
    peak_power = float(powers.sum(axis=1).max())
    yield KeyFigure(
        "power of the motors", f"{gave.mean():.0f} W", f"largest sum {peak_power:.0f} W"
    )


def _ticks(run: LoggedRun) -> Iterator[KeyFigure]:
    total = 1e6 * (run["estimator_time"] + run["controller_time"])
    median, high, worst = np.percentile(total, (50, 99, 100))
    note = f"99 %: {high:.0f} µs, longest {worst:.0f} µs"
    if len(run) > 1:
        note += f", budget {1e6 * np.median(np.diff(run.time)):.0f} µs"
    yield KeyFigure("time of a tick", f"{median:.0f} µs", note)
    failed = np.flatnonzero(run["status"] != 0)
    note = f"first at {run.time[failed[0]]:.3f} s" if failed.size else "every tick had a solution"
    yield KeyFigure("QP failures", str(failed.size), note, bool(failed.size))
