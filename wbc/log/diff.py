"""Compares two runs: when they diverge, in which quantity, and by how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wbc.log.errors import LogError
from wbc.log.run import LoggedRun

#: Stages of a tick, in order of cause and effect.
STAGES = ("measured", "estimated", "intended", "commanded")


@dataclass(frozen=True, eq=False)
class Signal:
    """A quantity of both runs at their common ticks.

    Attributes:
        name: Name of the quantity.
        stage: One of `STAGES`.
        unit: Unit of the values.
        parts: Name of each column.
        a: Values of the first run, shape (n, k).
        b: Values of the second run, shape (n, k).
    """

    name: str
    stage: str
    unit: str
    parts: tuple[str, ...]
    a: np.ndarray
    b: np.ndarray


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first tick at which a quantity differs between two runs, and the largest difference.

    Attributes:
        name: Name of the quantity.
        stage: One of `STAGES`.
        unit: Unit of the values.
        part: Component that differs first; of several, the one that differs most.
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


@dataclass(frozen=True, slots=True)
class Difference:
    """The differences between two runs.

    Attributes:
        ticks: Number of common ticks.
        ends: Time of the last tick of each run, s.
        divergences: One entry per quantity that differs, in order of time.
        parameters: Maps "table.name" to the values in both runs; None where a run has no value.
    """

    ticks: int
    ends: tuple[float, float]
    divergences: tuple[Divergence, ...]
    parameters: Mapping[str, tuple[str | None, str | None]]

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
    found = []
    for signal in _signals(a, b, in_a, in_b):
        divergence = _divergence(signal, 1e-9 * stamps, tolerance)
        if divergence is not None:
            found.append(divergence)
    found.sort(key=lambda p: (p.tick, STAGES.index(p.stage)))
    return Difference(
        ticks=len(stamps),
        ends=(float(a.time[-1]), float(b.time[-1])),
        divergences=tuple(found),
        parameters=_parameters(a, b),
    )


def _divergence(signal: Signal, time: np.ndarray, tolerance: float) -> Divergence | None:
    a, b = signal.a, signal.b
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
        name=signal.name,
        stage=signal.stage,
        unit=signal.unit,
        part=signal.parts[part],
        tick=tick,
        time=float(time[tick]),
        a=float(a[tick, part]),
        b=float(b[tick, part]),
        largest=float(finite[largest]),
        largest_time=float(time[largest]),
    )


def _signals(a: LoggedRun, b: LoggedRun, in_a: np.ndarray, in_b: np.ndarray) -> Iterator[Signal]:
    joints = a.robot_info.joints
    xyz = ("x", "y", "z")
    twist = ("vx", "vy", "vz", "ωx", "ωy", "ωz")
    wrench = ("fx", "fy", "fz", "τx", "τy", "τz")

    def both(name: str, stage: str, unit: str, parts: tuple[str, ...], read: object) -> Signal:
        assert callable(read)
        return Signal(name, stage, unit, parts, read(a)[in_a], read(b)[in_b])

    def topic(name: str, field: str) -> object:
        return lambda run: run.at_ticks(name, field)

    sensors = "/sensors/joint_states"
    yield both("encoder positions", "measured", "rad", joints, topic(sensors, "position"))
    yield both("encoder velocities", "measured", "rad/s", joints, topic(sensors, "velocity"))
    imu = "/sensors/imu"
    yield both("gyro", "measured", "rad/s", xyz, topic(imu, "angular_velocity"))
    yield both("accelerometer", "measured", "m/s²", xyz, topic(imu, "linear_acceleration"))
    for name in sorted({*a.foot_wrenches, *b.foot_wrenches}):
        yield both(
            f"wrench on {name}", "measured", "N, N·m", wrench,
            lambda run, name=name: _or_unknown(run, run.foot_wrenches.get(name), 6),
        )  # fmt: skip
    yield both("base position", "estimated", "m", xyz, lambda run: run.q[:, :3])
    yield both("base orientation", "estimated", "", ("qx", "qy", "qz", "qw"),
               lambda run: run.q[:, 3:7])  # fmt: skip
    yield both("base velocity", "estimated", "m/s, rad/s", twist, lambda run: run.v[:, :6])
    yield both("joint positions", "estimated", "rad", joints, lambda run: run.q[:, 7:])
    yield both("joint velocities", "estimated", "rad/s", joints, lambda run: run.v[:, 6:])
    yield both("CoM", "estimated", "m", xyz, lambda run: run.point("com"))
    yield both("DCM", "estimated", "m", xyz, lambda run: run.point("dcm"))
    yield both(
        "velocity wanted", "intended", "m/s, rad/s", ("forward", "left", "turn"),
        lambda run: np.column_stack(
            [run.state(f"velocity_{name}") for name in ("forward", "left", "turn")]
        ),
    )  # fmt: skip
    yield both("phase", "intended", "", ("phase",), lambda run: run.state("phase")[:, None])
    yield both("steps", "intended", "", ("steps",), lambda run: run.state("steps")[:, None])
    yield both("DCM reference", "intended", "m", xyz, lambda run: run.point("dcm_reference"))
    yield both("ZMP", "intended", "m", xyz, lambda run: run.point("zmp"))
    for name in sorted({*a.commanded_wrenches, *b.commanded_wrenches}):
        yield both(
            f"wrench wanted on {name}", "commanded", "N, N·m", wrench,
            lambda run, name=name: _or_unknown(run, run.commanded_wrenches.get(name), 6),
        )  # fmt: skip
    yield both("torques", "commanded", "N·m", joints, lambda run: run.tau)
    yield both("QP status", "commanded", "", ("status",), lambda run: run.state("status")[:, None])


def _or_unknown(run: LoggedRun, values: np.ndarray | None, columns: int) -> np.ndarray:
    return np.full((len(run), columns), np.nan) if values is None else values


def _parameters(a: LoggedRun, b: LoggedRun) -> dict[str, tuple[str | None, str | None]]:
    """Return the parameters that differ, except those that differ between any two runs."""
    flat = []
    for run in (a, b):
        flat.append(
            {
                f"{table}.{name}": value
                for table, values in run.log.tables.items()
                if table not in ("report", "log")
                for name, value in values.items()
                if (table, name) != ("run", "began")
            }
        )
    one, other = flat
    return {
        name: (one.get(name), other.get(name))
        for name in sorted({*one, *other})
        if one.get(name) != other.get(name)
    }
