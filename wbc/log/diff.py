"""Compares two runs: when they diverge, in which quantity, and by how much."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wbc.log.errors import LogError
from wbc.log.run import LoggedRun
from wbc.runtime.event import RunEvent
from wbc.runtime.schema import Column

#: Stages of a tick, in order of cause and effect, with the quantities that are compared. A name
#: stands for all quantities whose names have it before the slash.
STAGES: Mapping[str, tuple[str, ...]] = {
    "measured": ("joint_position", "joint_velocity", "gyro", "accelerometer", "foot_wrench"),
    "estimated": ("q", "v"),
    "intended": (
        "velocity_command", "heading", "phase", "steps", "com", "dcm", "dcm_reference", "zmp",
    ),
    "commanded": ("tau", "commanded_wrench", "acceleration", "q_target", "v_target", "status"),
}  # fmt: skip
_SIMULTANEOUS = 1e-3  # s; commands are given at whole ticks


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first tick at which a quantity differs between two runs, and the largest difference.

    Attributes:
        name: Name of the quantity.
        stage: One of `STAGES`.
        unit: Unit of the values.
        part: Component that differs first; of several, the one that differs most. It is empty for a
            number.
        tick: Number of the first common tick at which the quantity differs.
        time: Time of that tick, s.
        a: Value in the first run at that tick.
        b: Value in the second run at that tick.
        largest: Largest difference of any component from that tick on.
        largest_time: Time of the largest difference, s.
    """

    name: str
    stage: str
    unit: str
    part: str
    tick: int
    time: float
    a: float
    b: float
    largest: float
    largest_time: float

    @property
    def label(self) -> str:
        """Name of the component, e.g. "tau, leg_left_4_joint"."""
        return f"{self.name}, {self.part}" if self.part else self.name


@dataclass(frozen=True, slots=True)
class Difference:
    """The differences between two runs.

    Attributes:
        ticks: Number of common ticks.
        ends: Time of the last tick of each run, s.
        divergences: One entry per quantity that differs, in order of time.
        parameters: Maps "table.name" to the values in both runs; None where a run has no value.
        commands: The first accepted command that differs, in both runs; None where a run has no
            further command. Both are None if the runs had the same commands at the same times.
    """

    ticks: int
    ends: tuple[float, float]
    divergences: tuple[Divergence, ...]
    parameters: Mapping[str, tuple[str | None, str | None]]
    commands: tuple[RunEvent | None, RunEvent | None]

    @property
    def first(self) -> Divergence | None:
        """The first divergence; among quantities of the same tick, the earliest stage."""
        return self.divergences[0] if self.divergences else None


def compare(a: LoggedRun, b: LoggedRun, tolerance: float = 0.0) -> Difference:
    """Compare two runs of one robot tick by tick. Computation times are not compared.

    Args:
        a: First run.
        b: Second run.
        tolerance: Largest absolute difference that counts as equal, in SI units.

    Raises:
        LogError: The tolerance is negative, the robots have different joints, or the runs have no
            tick in common.
    """
    if not tolerance >= 0.0:
        raise LogError(f"tolerance = {tolerance} must be 0 or positive")
    if a.robot_info.joints != b.robot_info.joints:
        raise LogError(
            f"{a.log.path} logs '{a.robot_info.name}' and {b.log.path} logs '{b.robot_info.name}': "
            "robots with different joints cannot be compared"
        )
    stamps, in_a, in_b = np.intersect1d(a.stamps, b.stamps, return_indices=True)
    if not len(stamps):
        raise LogError(f"{a.log.path} and {b.log.path} have no tick in common")
    columns = {**b.quantities, **a.quantities}.values()
    found = []
    for stage, names in STAGES.items():
        for column in [c for name in names for c in columns if c.name.partition("/")[0] == name]:
            values = _values(a, column)[in_a], _values(b, column)[in_b]
            divergence = _divergence(column, stage, *values, 1e-9 * stamps, tolerance)
            found += [] if divergence is None else [divergence]
    found.sort(key=lambda divergence: divergence.tick)  # of the same tick, in order of the stages
    return Difference(
        ticks=len(stamps),
        ends=(float(a.time[-1]), float(b.time[-1])),
        divergences=tuple(found),
        parameters=_parameters(a, b),
        commands=_first_other_command(a, b),
    )


def _first_other_command(a: LoggedRun, b: LoggedRun) -> tuple[RunEvent | None, RunEvent | None]:
    """Return the first pair of commands that differ in time or content, up to the common end."""
    end = min(a.end, b.end)
    one, other = (
        [e for e in run.events if e.outcome == "accepted" and e.time <= end] for run in (a, b)
    )
    for first, second in itertools.zip_longest(one, other):
        if first is None or second is None or not _same_command(first, second):
            return first, second
    return None, None


def _same_command(a: RunEvent, b: RunEvent) -> bool:
    return (a.name, a.value) == (b.name, b.value) and abs(a.time - b.time) < _SIMULTANEOUS


def _values(run: LoggedRun, column: Column) -> np.ndarray:
    """Return the values of a quantity, shape (n, k); NaN if the run does not have it."""
    if column.name not in run:
        return np.full((len(run), column.size), np.nan)
    return run[column.name].reshape(len(run), column.size)


def _divergence(
    column: Column, stage: str, a: np.ndarray, b: np.ndarray, time: np.ndarray, tolerance: float
) -> Divergence | None:
    gap = np.abs(a - b)
    one_unknown = np.isnan(a) != np.isnan(b)
    gap[one_unknown] = np.inf
    gap[np.isnan(gap)] = 0.0
    beyond = (gap > tolerance).any(axis=1)
    if not beyond.any():
        return None
    tick = int(np.argmax(beyond))
    part = int(np.argmax(gap[tick]))
    finite = np.where(np.isfinite(gap), gap, 0.0).max(axis=1)
    largest = int(np.argmax(finite))
    return Divergence(
        name=column.name,
        stage=stage,
        unit=column.unit,
        part="" if column.scalar else column.labels[part],
        tick=tick,
        time=float(time[tick]),
        a=float(a[tick, part]),
        b=float(b[tick, part]),
        largest=float(finite[largest]),
        largest_time=float(time[largest]),
    )


def _parameters(a: LoggedRun, b: LoggedRun) -> dict[str, tuple[str | None, str | None]]:
    """Return the parameters that differ, except those that differ between any two runs."""
    one, other = (
        {
            f"{table}.{name}": value
            for table, values in run.log.tables.items()
            if table not in ("report", "log")
            for name, value in values.items()
            if (table, name) != ("run", "began")
        }
        for run in (a, b)
    )
    return {
        name: (one.get(name), other.get(name))
        for name in sorted({*one, *other})
        if one.get(name) != other.get(name)
    }
