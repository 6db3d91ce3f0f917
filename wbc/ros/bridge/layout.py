"""The form of a tick, and of how the ones before it went, between the loop and its ROS 2 node."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wbc.robot import Robot
from wbc.runtime.mode import Mode
from wbc.telemetry import PHASES

#: Numbers that stand first, in the order in which they are written.
HEAD = (
    "stamp",  # s since 1970
    "time",  # of the plant, s
    "run",
    "mode",
    "status",
    "phase",
    "steps",
    "dcm_error",  # m
    "timed",  # numbers in `timing`
)
MOST = 32  #: ticks that a record tells the timing of


@dataclass(frozen=True)
class Layout:
    """Sizes of a record, all of it float64.

    Attributes:
        nq: size of a configuration.
        nv: size of a velocity.
        feet: number of soles.
    """

    nq: int
    nv: int
    feet: int

    @staticmethod
    def of(robot: Robot) -> Layout:
        """The layout for a robot."""
        return Layout(robot.nq, robot.nv, len(robot.soles))

    @cached_property
    def body(self) -> tuple[tuple[str, int], ...]:
        """(name, size) of the arrays after the head."""
        return (
            ("q", self.nq),
            ("v", self.nv),
            ("tau", self.nv - 6),
            ("com", 3),
            ("dcm", 3),
            ("dcm_reference", 3),
            ("zmp", 3),
            ("wrenches", 6 * self.feet),
            ("timing", 3 * MOST),
        )

    @property
    def size(self) -> int:
        """Numbers in a record."""
        return len(HEAD) + sum(size for _, size in self.body)


@dataclass(frozen=True, slots=True)
class Sample:
    """A tick as the node sees it.

    Attributes:
        stamp: when it ended, s since 1970.
        time: of the plant, s.
        run: counts resets.
        mode: whether the loop runs.
        status: index into `wbc.Status`.
        phase: index into `PHASES`.
        steps: touchdowns so far.
        dcm_error: m.
        q: (nq,) configuration, Pinocchio's convention.
        v: (nv,) velocity, Pinocchio's convention.
        tau: (na,) joint torques, N·m.
        com: (3,) m, and likewise `dcm`, `dcm_reference` and `zmp`: world axes, NaN if not known.
        wrenches: (feet, 6) force then moment from the ground, sole axes; NaN if not known.
        timing: (n, 3) of the n ticks since the last sample, itself included: what estimator and
            controller took and the period since the tick before, s; then the status, see above.
    """

    stamp: float
    time: float
    run: int
    mode: Mode
    status: int
    phase: int
    steps: int
    dcm_error: float
    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    com: np.ndarray
    dcm: np.ndarray
    dcm_reference: np.ndarray
    zmp: np.ndarray
    wrenches: np.ndarray
    timing: np.ndarray

    @staticmethod
    def of(layout: Layout, record: np.ndarray) -> Sample:
        """A sample of a record, which it keeps views of."""
        head = record[: len(HEAD)].tolist()
        stamp, time, run, mode, status, phase, steps, error, timed = head
        arrays, start = {}, len(HEAD)
        for name, size in layout.body:
            arrays[name] = record[start : start + size]
            start += size
        arrays["wrenches"] = arrays["wrenches"].reshape(-1, 6)
        arrays["timing"] = arrays["timing"][: int(timed)].reshape(-1, 3)
        return Sample(
            stamp,
            time,
            int(run),
            Mode(int(mode)),
            int(status),
            int(phase),
            int(steps),
            error,
            **arrays,
        )

    @property
    def phase_name(self) -> str:
        """What carries the robot."""
        return PHASES[self.phase]
