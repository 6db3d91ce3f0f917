"""Measures the lateness of the ticks of a real-time loop under different settings.

The loop is `wbc.run(..., real_time=True)` with the walker's computation in each tick. A walk in
MuJoCo with sensor noise is recorded once for every rate; then its measurements are replayed through
estimator, walker and loop. The physics is excluded, as on a real robot. The replaying plant records
when the loop requests each measurement; the delay behind a perfect schedule is the lateness of the
tick, independent of the loop's own statistics. A tick that begins when the next one is already due
is an overrun. Stolen time is the time that the hypervisor gave to other machines; the lateness of
the idle loop is that of the machine.

The settings are measured in turn, in rounds, so that other load on the machine affects all of them.

    python benchmarks/loop.py                     # 1 minute for each cell, about 20 minutes
    python benchmarks/loop.py --busy 2            # beside two processes that compute all the time
    python benchmarks/loop.py --rate 500 --duration 300 --plot out/loop.png --json out/loop.json
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import contextlib
import gc
import json
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from shared.observed_loop import ObservedLoop, observed
from shared.replay import Idle, Replay, lateness, record, walker

import wbc

LENGTH = 20.0  # s, of the recorded walk


@dataclass(frozen=True)
class Setting:
    """The settings of a loop.

    Attributes:
        name: Name in the table.
        observers: Names in `OBSERVERS`.
        collector: Whether Python's garbage collection stays enabled.
        priority: Whether the loop requests real-time priority and locks its memory.
        walker: Whether each tick runs the walker; otherwise the ticks are idle.
    """

    name: str
    observers: tuple[str, ...] = ()
    collector: bool = False
    priority: bool = True
    walker: bool = True


SETTINGS = (
    Setting("idle", walker=False),
    Setting("walker"),
    Setting("+ viewer", ("viewer",)),
    Setting("+ log", ("log",)),
    Setting("+ viewer, log", ("viewer", "log")),
    Setting("+ garbage collection", collector=True),
    Setting("no priority", priority=False),
    Setting("no priority + viewer, log", ("viewer", "log"), priority=False),
    Setting("no priority + all three", ("viewer", "log"), collector=True, priority=False),
)


@dataclass
class LoopTimes:
    """The times of one setting, s, one value per tick."""

    late: list[np.ndarray] = field(default_factory=list)
    work: list[np.ndarray] = field(default_factory=list)
    conditions: str = ""
    stolen: float = 0.0

    def add(self, other: LoopTimes) -> None:
        """Append the times of another round."""
        self.late += other.late
        self.work += other.work
        self.conditions = other.conditions
        self.stolen += other.stolen


@contextlib.contextmanager
def neighbour() -> Iterator[int]:
    """Yield the id of a process at normal priority that computes while the context lasts."""
    computing = (sys.executable, "-c", "while True: sum(bytearray(200_000))")
    process = subprocess.Popen(computing, stderr=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.kill()
        process.wait()


def stolen() -> float:
    """Return the CPU time that the hypervisor has given to others, s; NaN if unknown."""
    try:
        fields = Path("/proc/stat").read_text("ascii").split("\n", 1)[0].split()
        return float(fields[8]) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return float("nan")


def measure(
    setting: Setting, robot: wbc.Robot, dt: float, walk: list[wbc.Measurement], speed: float
) -> LoopTimes:
    """Run one round of a setting."""
    plant = Replay(robot, dt, walk)
    idle, ordinary = Idle(robot), wbc.RealTime(0, False, sys.getswitchinterval())
    controller = walker(robot, dt, speed) if setting.walker else idle

    def collect(_: float) -> None:
        if plant.ticks == 0 and setting.collector:
            gc.unfreeze()
            gc.enable()

    with tempfile.TemporaryDirectory(prefix="wbc-loop-") as folder:
        loop = ObservedLoop(controller, plant, Path(folder), before_tick=collect)
        with observed(loop, setting.observers):
            before = stolen()
            report, conditions = loop.run(
                len(walk) * dt,
                wbc.RealTime() if setting.priority else ordinary,
                None if setting.walker else idle,
            )
            after = stolen()
    if not report.survived:
        raise SystemExit(f"'{setting.name}' deviates from the recorded walk: {report.fell_why}")
    work = plant.commanded_at - plant.measured_at
    return LoopTimes([lateness(plant.measured_at, dt)], [work], conditions, after - before)


def summary(setting: Setting, rate: float, times: LoopTimes) -> dict[str, Any]:
    """Return a row of the table, times in µs."""
    late, work = (1e6 * np.concatenate(parts) for parts in (times.late, times.work))
    return {
        "rate_hz": rate,
        **asdict(setting),
        "ticks": late.size,
        **{f"late_p{q}_us": float(np.percentile(late, q)) for q in (50, 99, 99.9)},
        "late_max_us": float(late.max()),
        "overruns": int((late >= 1e6 / rate).sum()),
        "work_p50_us": float(np.median(work)),
        "work_p99_us": float(np.percentile(work, 99)),
        "stolen_s": times.stolen,
        "conditions": times.conditions,
    }


def show(lines: list[dict[str, Any]]) -> None:
    """Print the table."""
    print(
        f"{'':<34}{'begins late, µs':>32}{'':>20}{'work, µs':>17}\n"
        f"{'rate':>5}  {'loop':<27}{'p50':>8}{'p99':>8}{'p99.9':>8}{'max':>8}"
        f"{'overruns':>10}{'ticks':>10}{'p50':>9}{'p99':>8}{'stolen s':>10}"
    )
    for line in lines:
        print(
            f"{line['rate_hz']:>5.0f}  {line['name']:<27}{line['late_p50_us']:>8.1f}"
            f"{line['late_p99_us']:>8.1f}{line['late_p99.9_us']:>8.0f}{line['late_max_us']:>8.0f}"
            f"{line['overruns']:>10}{line['ticks']:>10}{line['work_p50_us']:>9.0f}"
            f"{line['work_p99_us']:>8.0f}{line['stolen_s']:>10.2f}"
        )


def plot(cells: Mapping[tuple[float, Setting], LoopTimes], path: Path) -> None:
    """Plot the share of ticks that began later than a given time, µs, for each setting."""
    try:
        import matplotlib
        from matplotlib import pyplot
    except ImportError as error:
        raise SystemExit("--plot needs matplotlib: pip install 'wbc[plots]'") from error
    matplotlib.use("Agg")

    rates = sorted({rate for rate, _ in cells})
    size = (6.0 * len(rates), 4.6)
    figure, axes = pyplot.subplots(1, len(rates), figsize=size, squeeze=False, layout="constrained")
    for ax, rate in zip(axes[0], rates, strict=True):
        for (own, setting), times in cells.items():
            if own != rate:
                continue
            late = np.sort(1e6 * np.concatenate(times.late))
            later = 1.0 - np.arange(late.size) / late.size
            style = "-" if setting.priority else "--"
            ax.loglog(np.maximum(late, 0.1), later, style, label=setting.name, lw=1.4)
        ax.axvline(1e6 / rate, color="k", lw=0.8, ls=":")
        ax.text(1e6 / rate, 1.0, " overrun", va="bottom", fontsize=8)
        ax.set(
            title=f"{rate:g} Hz", xlabel="lateness, µs", ylabel="share of ticks that began later"
        )
        ax.grid(alpha=0.3, which="both", lw=0.4)
    axes[0][0].legend(fontsize=8, loc="lower left")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Record and replay, print the table, and write the JSON file and the plot."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--rate", type=float, action="append", help="Hz (default: 500 and 1000)")
    parser.add_argument("--speed", type=float, default=0.3, help="m/s (default: %(default)s)")
    parser.add_argument(
        "--duration", type=float, default=60.0, help="of each cell, s (default: %(default)s)"
    )
    parser.add_argument("--only", action="append", metavar="TEXT", help="cells whose name has it")
    parser.add_argument(
        "--busy", type=int, default=0, metavar="N", help="beside N processes that compute"
    )
    parser.add_argument("--quick", action="store_true", help="4 s for each cell")
    parser.add_argument("--json", type=Path, help="write the table there")
    parser.add_argument("--plot", type=Path, help="draw the lateness there")
    options = parser.parse_args()

    duration = 4.0 if options.quick else options.duration
    rounds = max(1, round(duration / LENGTH))
    length = duration / rounds
    robot = wbc.load(options.robot)
    chosen = [s for s in SETTINGS if not options.only or any(t in s.name for t in options.only)]
    rates = options.rate or [500.0, 1000.0]
    walks = {rate: record(robot, 1.0 / rate, options.speed, length) for rate in rates}
    cells = {(rate, setting): LoopTimes() for rate in rates for setting in chosen}
    with contextlib.ExitStack() as stack:
        for _ in range(options.busy):
            stack.enter_context(neighbour())
        for done in range(rounds):
            print(f"round {done + 1} of {rounds}", file=sys.stderr)
            for (rate, setting), times in cells.items():
                times.add(measure(setting, robot, 1.0 / rate, walks[rate], options.speed))
    lines = [summary(setting, rate, times) for (rate, setting), times in cells.items()]
    about = {"robot": robot.name, "busy": options.busy, "processors": os.cpu_count()}
    about |= {"kernel": platform.release(), "load": os.getloadavg()}
    print(", ".join(f"{key} {value}" for key, value in about.items()))
    show(lines)
    for text in dict.fromkeys(line["conditions"] for line in lines):
        print(text)
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps({**about, "cells": lines}, indent=1) + "\n")
    if options.plot:
        plot(cells, options.plot)


if __name__ == "__main__":
    main()
