"""How long one tick of the whole-body controller takes, stage by stage.

A short walk in MuJoCo is recorded (states and foot wrenches); then a fresh walker replays
it, so that every tick solves the problem of real walking, and only its own work is timed:
kinematics, assembly of the QP, the solver, and the command. Gait and balance are left out.
It is replayed several times, and of each tick the fastest counts: on a shared machine other
work only ever adds time.

    python benchmarks/tick.py --breakdown
    python benchmarks/tick.py --robot g1 --support single --json out/tick.json
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import gc
import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import wbc
from wbc.kinematics import Kinematics
from wbc.qp.compiled import CompiledAssembly
from wbc.sim import Mujoco

STAGES = ("kinematics", "assembly", "solver", "command")
Tick = tuple[wbc.State, dict[str, np.ndarray] | None]


class Recorder:
    """A walker that keeps what it was given."""

    def __init__(self, walker: wbc.Walker) -> None:
        self.walker = walker
        self.ticks: list[Tick] = []

    def reset(self, state: wbc.State) -> None:
        self.start = state
        self.walker.reset(state)

    def step(
        self, state: wbc.State, foot_wrenches: Mapping[str, np.ndarray] | None = None
    ) -> wbc.Command:
        wrenches = {k: w.copy() for k, w in foot_wrenches.items()} if foot_wrenches else None
        self.ticks.append((wbc.State(state.q.copy(), state.v.copy()), wrenches))
        return self.walker.step(state, foot_wrenches)


class Stopwatch:
    """Wraps methods and adds up the time spent in each during a tick, in µs."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = {}

    def wrap(self, owner: Any, method: str, stage: str) -> None:
        inner: Callable[..., Any] = getattr(owner, method)
        spent, clock = self.spent, time.perf_counter

        def timed(*args: Any) -> Any:
            start = clock()
            result = inner(*args)
            spent[stage] = spent.get(stage, 0.0) + 1e6 * (clock() - start)
            return result

        setattr(owner, method, timed)


def record(robot: wbc.Robot, speed: float, duration: float, solver: str) -> Recorder:
    """Walk in physics from standing, and keep the ticks."""
    recorder = Recorder(wbc.Walker(robot, solver=solver))
    recorder.walker.velocity = (speed, 0.0, 0.0)
    with Mujoco(robot, ground_truth=True) as plant:
        report = wbc.run(recorder, plant, duration, estimator=wbc.GroundTruthEstimator())
    if not report.survived:
        raise SystemExit(f"{robot.name} fell at {report.fell_at_s:.2f} s: {report.fell_why}")
    return recorder


def replay(
    robot: wbc.Robot, recorder: Recorder, speed: float, solver: str
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Per stage (ticks,) µs, and (ticks,) number of contacts."""
    walker = wbc.Walker(robot, solver=solver)
    walker.reset(recorder.start)
    walker.velocity = (speed, 0.0, 0.0)
    watch = Stopwatch()
    originals = [(c, m, getattr(c, m)) for c, m in ((Kinematics, "update"), (CompiledAssembly, "build"))]
    watch.wrap(Kinematics, "update", "kinematics")
    watch.wrap(CompiledAssembly, "build", "assembly")
    watch.wrap(walker.controller.solver, "solve", "solver")
    watch.wrap(walker.controller, "solve", "solve")
    rows, contacts = [], []
    gc.collect()
    gc.disable()
    for state, wrenches in recorder.ticks:
        watch.spent.clear()
        walker.step(state, wrenches)
        rows.append(dict(watch.spent))
        contacts.append(len(walker.controller.contacts))
    gc.enable()
    for owner, method, inner in originals:
        setattr(owner, method, inner)
    times = {s: np.array([row.get(s, 0.0) for row in rows]) for s in (*STAGES, "solve")}
    times["command"] = times["solve"] - times["assembly"] - times["solver"]
    times["tick"] = times["kinematics"] + times.pop("solve")
    return times, np.array(contacts)


def main() -> None:
    """Record, replay, print the table, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--support", choices=("double", "single", "both"), default="both")
    parser.add_argument("--speed", type=float, default=0.3, help="m/s (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=3.0, help="s of walking recorded")
    parser.add_argument("--repeat", type=int, default=5, help="replays (default: %(default)s)")
    parser.add_argument("--solver")
    parser.add_argument("--breakdown", action="store_true", help="median of each stage, too")
    parser.add_argument("--json", type=Path, help="write the table there")
    args = parser.parse_args()
    robot = wbc.load(args.robot)
    recorder = record(robot, args.speed, args.duration, args.solver)
    runs = [replay(robot, recorder, args.speed, args.solver) for _ in range(args.repeat)]
    contacts = runs[0][1]
    times = {s: np.min([run[0][s] for run in runs], axis=0) for s in runs[0][0]}
    table = {}
    for support, count in (("double", 2), ("single", 1)):
        chosen = contacts == count
        if args.support not in (support, "both") or not chosen.any():
            continue
        tick = times["tick"][chosen]
        row = {"ticks": int(chosen.sum()), "p50_us": float(np.median(tick))}
        row |= {"p99_us": float(np.percentile(tick, 99)), "max_us": float(tick.max())}
        row |= {f"{s}_us": float(np.median(times[s][chosen])) for s in STAGES}
        table[support] = row
    print(f"{robot.name}, nv = {robot.nv}, {args.solver}, walking at {args.speed} m/s, µs")
    shown = ["ticks", "p50_us", "p99_us", "max_us"]
    shown += [f"{s}_us" for s in STAGES] if args.breakdown else []
    print("support " + "".join(f"{c.removesuffix('_us'):>12}" for c in shown))
    for support, row in table.items():
        print(f"{support:<8}" + "".join(f"{row[c]:>12.0f}" for c in shown))
    if args.json:
        args.json.write_text(json.dumps({"robot": robot.name, **table}, indent=2) + "\n")


if __name__ == "__main__":
    main()
