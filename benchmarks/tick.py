"""Measures the tick of the whole-body controller, by stage and against other libraries.

A short walk in MuJoCo is recorded (states and foot wrenches); then a fresh walker replays
it, so that every tick solves the problem of real walking, and only the controller's own work is
timed: from the state to the command. Gait and balance are left out. The walk is replayed several
times, and the minimum of each tick is used: other load on a shared machine can only add time.

    python benchmarks/tick.py
    python benchmarks/tick.py --breakdown
    python benchmarks/tick.py --robot g1 --support single --json out/tick.json
    python benchmarks/tick.py --peers                  # against TSID, placo and pink
    python benchmarks/tick.py --memory 600
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import copy
import gc
import json
import resource
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import wbc
from wbc.kinematics import Kinematics
from wbc.qp.compiled import CompiledAssembly
from wbc.sim import Mujoco

#: Description of each stage; "diagnostics" is the remainder of the tick.
STAGES = {
    "kinematics": "mass matrix, bias forces and Jacobian by Pinocchio; the state is checked",
    "references": "references, gains and bounds of tasks, contacts and limits are copied",
    "assembly": "frames, rows of tasks and contacts, elimination, cost and constraints",
    "solve": "the quadratic program",
    "recovery": "accelerations, torques, wrenches and targets from the solution",
    "diagnostics": "choice of the assembly, checks for finite values, status",
}


class Recorder:
    """A walker that records the estimates that it receives."""

    def __init__(self, walker: wbc.Walker) -> None:
        self.walker = walker
        self.ticks: list[wbc.Estimate] = []

    def reset(self, state: wbc.State) -> None:
        self.start = state
        self.walker.reset(state)

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        self.ticks.append(copy.deepcopy(estimate))
        return self.walker.step(estimate)


class Stopwatch:
    """Wraps methods and adds up the time spent in each during a tick, in µs."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = {}
        self._wrapped: list[tuple[Any, str, Any]] = []

    def wrap(self, owner: Any, method: str, stage: str) -> None:
        inner: Callable[..., Any] = getattr(owner, method)
        self._wrapped.append((owner, method, inner))
        spent, clock = self.spent, time.perf_counter

        def timed(*args: Any) -> Any:
            start = clock()
            result = inner(*args)
            spent[stage] = spent.get(stage, 0.0) + 1e6 * (clock() - start)
            return result

        setattr(owner, method, timed)

    def unwrap(self) -> None:
        for owner, method, inner in reversed(self._wrapped):
            setattr(owner, method, inner)


def record(robot: wbc.Robot, speed: float, duration: float) -> Recorder:
    """Walk in simulation from standing, and record the ticks."""
    recorder = Recorder(wbc.Walker(robot))
    recorder.walker.velocity = (speed, 0.0, 0.0)
    with Mujoco(robot, ground_truth=True) as plant:
        report = wbc.run(recorder, plant, duration, estimator=wbc.GroundTruthEstimator(robot))
    if not report.survived:
        raise SystemExit(f"{robot.name} fell at {report.fell_at_s:.2f} s: {report.fell_why}")
    return recorder


def replay(
    robot: wbc.Robot, recorder: Recorder, speed: float, staged: bool
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return the time of each stage, µs, and the number of contacts, each of shape (ticks,)."""
    walker = wbc.Walker(robot)
    walker.reset(recorder.start)
    walker.velocity = (speed, 0.0, 0.0)
    watch = Stopwatch()
    if staged:
        watch.wrap(CompiledAssembly, "update", "references")
        watch.wrap(CompiledAssembly, "assemble", "assembly")
        watch.wrap(CompiledAssembly, "recover", "recovery")
        watch.wrap(walker.controller.solver, "solve", "solve")
    watch.wrap(Kinematics, "update", "kinematics")
    watch.wrap(walker.controller, "solve", "controller")
    rows, contacts = [], []
    gc.collect()
    gc.disable()
    for estimate in recorder.ticks:
        watch.spent.clear()
        walker.step(estimate)
        rows.append(dict(watch.spent))
        contacts.append(len(walker.controller.contacts))
    gc.enable()
    watch.unwrap()
    stages = [*STAGES, "controller"]
    times = {s: np.array([row.get(s, 0.0) for row in rows]) for s in stages}
    times["tick"] = times["kinematics"] + times.pop("controller")
    others = sum(times[s] for s in STAGES if s != "diagnostics")
    times["diagnostics"] = times["tick"] - others
    return times, np.array(contacts)


def fastest(runs: list[tuple[dict[str, np.ndarray], np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the minimum over the replays for each tick and stage."""
    return {s: np.min([run[0][s] for run in runs], axis=0) for s in runs[0][0]}


def allocations(robot: wbc.Robot, recorder: Recorder, speed: float) -> dict[str, float]:
    """Return the objects that a walker step leaves allocated, and its transient memory."""
    walker = wbc.Walker(robot)
    walker.reset(recorder.start)
    walker.velocity = (speed, 0.0, 0.0)
    for estimate in recorder.ticks:
        walker.step(estimate)
    kin = Kinematics(robot, recorder.ticks[-1].state)
    controller, ticks = walker.controller, 2000
    controller.solve(kin)
    gc.collect()
    gc.disable()
    tracemalloc.start()
    controller.solve(kin)
    tracemalloc.reset_peak()
    before = tracemalloc.get_traced_memory()[0]
    controller.solve(kin)
    transient = tracemalloc.get_traced_memory()[1] - before
    tracemalloc.stop()
    blocks = sys.getallocatedblocks()
    for _ in range(ticks):
        controller.solve(kin)
    grown = sys.getallocatedblocks() - blocks
    gc.enable()
    return {"transient_bytes": float(transient), "blocks_grown_per_tick": grown / ticks}


def memory(robot: wbc.Robot, recorder: Recorder, speed: float, duration: float) -> None:
    """Replay the walk until its ticks add up to a duration; print the process's memory."""
    rounds = max(1, round(duration / 0.002 / len(recorder.ticks)))
    walker = wbc.Walker(robot)
    walker.velocity = (speed, 0.0, 0.0)
    print(f"{'ticks':>10}{'blocks':>12}{'largest RSS, MB':>18}")
    for k in range(rounds + 1):
        if k in (0, 1, rounds // 2, rounds):
            gc.collect()
            rss = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(f"{k * len(recorder.ticks):>10}{sys.getallocatedblocks():>12}{rss:>18.1f}")
        if k < rounds:
            walker.reset(recorder.start)
            for estimate in recorder.ticks:
                walker.step(estimate)


def table_of(
    robot: wbc.Robot, recorder: Recorder, speed: float, repeat: int, supports: tuple[str, ...]
) -> dict[str, dict[str, float]]:
    """Return the figures by support phase: the whole tick, and medians of its stages."""
    bare = [replay(robot, recorder, speed, False) for _ in range(repeat)]
    staged = fastest([replay(robot, recorder, speed, True) for _ in range(repeat)])
    times, contacts = fastest(bare), bare[0][1]
    table = {}
    for support, count in (("double", 2), ("single", 1)):
        chosen = contacts == count
        if support not in supports or not chosen.any():
            continue
        tick = times["tick"][chosen]
        row = {"ticks": float(chosen.sum()), "p50_us": float(np.median(tick))}
        row |= {"p99_us": float(np.percentile(tick, 99)), "max_us": float(tick.max())}
        row |= {f"{s}_us": float(np.median(staged[s][chosen])) for s in STAGES}
        table[support] = row
    return table


def print_table(table: dict[str, dict[str, float]], breakdown: bool) -> None:
    """Print the table."""
    print("support " + "".join(f"{c:>9}" for c in ("ticks", "p50", "p99", "max")))
    for support, row in table.items():
        print(f"{support:<8}{row['ticks']:>9.0f}", end="")
        print("".join(f"{row[c]:>9.0f}" for c in ("p50_us", "p99_us", "max_us")))
    if not breakdown:
        return
    for support, row in table.items():
        total = sum(row[f"{s}_us"] for s in STAGES)
        print(f"\n{support} support: medians of the stages")
        for stage, text in STAGES.items():
            time_us = row[f"{stage}_us"]
            print(f"  {stage:<12}{time_us:>6.1f} µs{100 * time_us / total:>5.0f} %   {text}")
        extra = total - row["p50_us"]
        print(
            f"  {'sum':<12}{total:>6.1f} µs, {extra:+.1f} relative to the tick without stage timing"
        )


def main() -> None:
    """Record and replay, print the table and write the JSON file."""
    if "--peers" in sys.argv:
        from peers.compare import main as compare

        return compare(sys.argv[1:])
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--peers",
        action="store_true",
        help="compare with TSID, placo and pink instead; see --peers --help for its flags",
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--support", choices=("double", "single", "both"), default="both")
    parser.add_argument("--speed", type=float, default=0.3, help="m/s (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=3.0, help="s of walking recorded")
    parser.add_argument("--repeat", type=int, default=5, help="replays (default: %(default)s)")
    parser.add_argument("--breakdown", action="store_true", help="the stages, and allocations")
    parser.add_argument(
        "--memory",
        type=float,
        metavar="S",
        help="only check whether memory grows over S seconds of ticks",
    )
    parser.add_argument("--json", type=Path, help="write the table to this file")
    args = parser.parse_args()
    robot = wbc.load(args.robot)
    recorder = record(robot, args.speed, args.duration)
    if args.memory:
        memory(robot, recorder, args.speed, args.memory)
        return
    supports = ("double", "single") if args.support == "both" else (args.support,)
    table = table_of(robot, recorder, args.speed, args.repeat, supports)
    print(f"{robot.name}, nv = {robot.nv}, walking at {args.speed} m/s, µs")
    print_table(table, args.breakdown)
    found = allocations(robot, recorder, args.speed) if args.breakdown else {}
    if found:
        print(
            f"\nmemory: {found['transient_bytes']:.0f} bytes transient, "
            f"{found['blocks_grown_per_tick']:.3f} objects left allocated per tick"
        )
    if args.json:
        content = {"robot": robot.name, **table, **found}
        args.json.write_text(json.dumps(content, indent=2) + "\n")


if __name__ == "__main__":
    main()
