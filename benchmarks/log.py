"""Measures the load of a log of every tick on the control loop and on the disk.

The loop is `wbc.run(..., real_time=True)` at 500 Hz with the walker's computation in every tick; a
walk in MuJoCo is recorded once and replayed, which excludes the physics. Measured are the
calls that log a tick (`TickStream.write` and `FlightRecorder.observe`), with and without a contact
plan in it (30 per second have one), the walker's tick time in the same loop with and without a log,
and the log writer's CPU time, longest write and file size. A write takes milliseconds; no call in
the loop takes as long, because the log writer is another process.

Runs with and without a log alternate, so that other load on the machine affects both equally.

The table also lists the size of each topic, compressed by itself in chunks of the same duration.
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import contextlib
import json
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap.reader import make_reader
from shared.replay import Replay, record, walker

import wbc
from wbc.log import FlightRecorder
from wbc.log.reader import Log
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick

DT = 0.002  # s
CHUNK = 0.4  # s, as in the log writer


class Timed:
    """Times the calls of a flight recorder and its stream in each tick."""

    def __init__(self, recorder: FlightRecorder, robot: wbc.Robot) -> None:
        self._recorder, self._stream = recorder, TickStream(robot)
        recorder.attach(self._stream)
        self.begin, self.end = recorder.begin, recorder.end
        self.spent: list[float] = []
        self.with_plan: list[bool] = []

    def observe(self, tick: Tick) -> None:
        start = time.perf_counter()
        self._stream.write(tick)
        self._recorder.observe(tick)
        self.spent.append(time.perf_counter() - start)
        self.with_plan.append(tick.contact_plan is not None)


def run(
    robot: wbc.Robot, walk: list[wbc.Measurement], speed: float, log: Timed | None
) -> tuple[np.ndarray, int]:
    """Run one round; return the computation time of every tick, s, and the number of overruns."""
    plant = Replay(robot, DT, walk)
    report = wbc.run(
        walker(robot, DT, speed),
        plant,
        len(walk) * DT,
        real_time=True,
        on_conditions=lambda _: None,
        observers=[] if log is None else [log],
    )
    if not report.survived:
        raise SystemExit(f"{robot.name} deviates from the recorded walk: {report.fell_why}")
    return plant.commanded_at - plant.measured_at, report.overruns


def megabytes_per_minute(path: Path, seconds: float) -> dict[str, float]:
    """Return the compressed size of each topic of a log, MB per minute, the largest first."""
    messages: defaultdict[str, list[bytes]] = defaultdict(list)
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            messages[channel.topic].append(message.data)
    found = {}
    for topic, data in messages.items():
        step = max(1, round(len(data) * CHUNK / seconds))
        pieces = [b"".join(data[i : i + step]) for i in range(0, len(data), step)]
        size = sum(len(zstandard.compress(piece)) for piece in pieces)
        found[topic] = size / 1e6 / (seconds / 60.0)
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def measure(name: str, seconds: float, rounds: int, speed: float) -> dict[str, Any]:
    """Measure all figures of a robot."""
    robot = wbc.load(name)
    walk = record(robot, DT, speed, seconds)
    plain, logged, spent, planned = [], [], [], []
    overruns = {"without": 0, "with": 0}
    facts: list[dict[str, float]] = []
    for _ in range(rounds):
        work, late = run(robot, walk, speed, None)
        plain.append(work)
        overruns["without"] += late
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "walk.mcap"
            with FlightRecorder(path, robot) as recorder:
                timed = Timed(recorder, robot)
                work, late = run(robot, walk, speed, timed)
            logged.append(work)
            overruns["with"] += late
            spent.append(timed.spent)
            log = Log(path)
            planned.append(timed.with_plan)
            topics = megabytes_per_minute(path, len(walk) * DT)
            facts.append(
                {
                    "megabytes": path.stat().st_size / 1e6,
                    **{key: float(value) for key, value in log.tables["log"].items()},
                }
            )
    calls = 1e6 * np.concatenate(spent)
    plan = np.concatenate(planned)
    without, with_log = 1e6 * np.concatenate(plain), 1e6 * np.concatenate(logged)
    total = with_log + calls
    minutes = len(walk) * DT / 60.0
    return {
        "robot": robot.name,
        "joints": robot.na,
        "call_p50_us": float(np.median(calls)),
        "call_p99_us": float(np.percentile(calls, 99)),
        "call_max_us": float(calls.max()),
        "call_without_plan_p50_us": float(np.median(calls[~plan])),
        "call_without_plan_p99_us": float(np.percentile(calls[~plan], 99)),
        "call_with_plan_p50_us": float(np.median(calls[plan])),
        "work_p50_us": float(np.median(without)),
        "work_p99_us": float(np.percentile(without, 99)),
        "work_p50_ratio": float(np.median(with_log) / np.median(without)),
        "work_p99_ratio": float(np.percentile(with_log, 99) / np.percentile(without, 99)),
        "work_and_call_p50_ratio": float(np.median(total) / np.median(without)),
        "work_and_call_p99_ratio": float(np.percentile(total, 99) / np.percentile(without, 99)),
        "overruns_without": overruns["without"],
        "overruns_with": overruns["with"],
        "ticks": len(calls),
        "dropped": sum(f["dropped"] for f in facts),
        "megabytes_per_minute": float(np.median([f["megabytes"] for f in facts])) / minutes,
        "longest_write_ms": 1e3 * max(f["longest_write_s"] for f in facts),
        "writer_cpu_percent": 100.0
        * float(np.median([f["cpu_s"] for f in facts]))
        / (len(walk) * DT),
        "topics": topics,
    }


def show(row: dict[str, Any]) -> None:
    """Print a robot's figures."""
    print(f"{row['robot']}, {row['joints']} joints, {row['ticks']} ticks with a log")
    print(
        f"  a call               {row['call_p50_us']:7.1f} µs median  "
        f"{row['call_p99_us']:7.1f} µs p99  {row['call_max_us']:9.1f} µs max"
    )
    print(
        f"    without a plan     {row['call_without_plan_p50_us']:7.1f} µs median  "
        f"{row['call_without_plan_p99_us']:7.1f} µs p99"
    )
    print(f"    with a plan        {row['call_with_plan_p50_us']:7.1f} µs median")
    print(
        f"  work without a log   {row['work_p50_us']:7.1f} µs median  "
        f"{row['work_p99_us']:7.1f} µs p99"
    )
    print(
        f"  work with / without  {row['work_p50_ratio']:7.3f}    median  "
        f"{row['work_p99_ratio']:7.3f}    p99"
    )
    print(
        f"    with the call      {row['work_and_call_p50_ratio']:7.3f}    median  "
        f"{row['work_and_call_p99_ratio']:7.3f}    p99"
    )
    print(f"  overruns             {row['overruns_without']} without, {row['overruns_with']} with")
    print(
        f"  log writer's process {row['writer_cpu_percent']:.1f} % of a core, longest write "
        f"{row['longest_write_ms']:.1f} ms, {row['dropped']:.0f} ticks dropped"
    )
    print(f"  file size            {row['megabytes_per_minute']:.1f} MB per minute")
    for topic, size in row["topics"].items():
        print(f"    {topic:<34}{size:6.2f}")


def main() -> None:
    """Run the measurements, print the results and write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", nargs="+", default=["talos", "g1"])
    parser.add_argument("--seconds", type=float, default=20.0, help="of each run")
    parser.add_argument("--rounds", type=int, default=3, help="with and without a log in turn")
    parser.add_argument("--speed", type=float, default=0.2, help="of the walk, m/s")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()
    rows = []
    for name in options.robot:
        with contextlib.redirect_stderr(None):
            rows.append(measure(name, options.seconds, options.rounds, options.speed))
        show(rows[-1])
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
