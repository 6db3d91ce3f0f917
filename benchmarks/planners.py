"""Compares the planners by name: tracking, pushes, and time.

Each robot walks forward in MuJoCo with noisy sensors and the estimator. The DCM error is the
distance of the estimated DCM from the analytic plan of the planner's own footsteps while it walks,
which means the same for every planner. The time is what the planner itself takes in a control
period (CPU time of the loop's thread): a planner that does not plan in every period has its plans
in the 99th percentile. A push is an impulse on the torso for 0.1 s at three phases of the gait
from four directions; the table has how many trials were survived. Pushes need the extra `trials`.

    python benchmarks/planners.py
    python benchmarks/planners.py --robot g1 --sizes 0.3 0.5 0.7 --seeds 3
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import wbc
from wbc.gait import DcmPlanner
from wbc.gait.planners import PLANNER_NAMES
from wbc.sim import Mujoco
from wbc.trials import (
    ControllerSpec,
    Grid,
    RobotCases,
    local_workers,
    run_grid,
    survival_rates,
)

SPEEDS = {"talos": 0.3, "g1": 0.3, "simple_humanoid": 0.3}
SETTLE = 0.5  # s of standing before the first step
CRUISE = 2.0  # s; from then on the DCM error counts


class Stopwatch:
    """Accumulates the time that a planner takes in each control period, s."""

    def __init__(self, planner: Any) -> None:
        self.periods: list[float] = []
        self._inside = False  # a method of the planner that another one calls counts once
        for name in ("next_swing", "update", "reference"):
            setattr(planner, name, self._around(getattr(planner, name)))

    def _around(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            if self._inside:
                return method(*args, **kwargs)
            self._inside = True
            begun = time.thread_time()
            try:
                return method(*args, **kwargs)
            finally:
                self.periods[-1] += time.thread_time() - begun
                self._inside = False

        return timed


def walk(name: str, planner: str, speed: float, duration: float) -> dict[str, float]:
    """Walk, and return DCM error (mm) and times (µs)."""
    robot = wbc.load(name)
    walker = wbc.Walker(robot, planner=planner)
    stopwatch = Stopwatch(walker.planner)
    errors: list[float] = []

    def before_tick(now: float) -> None:
        state = walker.gait_state
        if now > CRUISE:
            analytic = DcmPlanner.reference(walker.planner, state)
            errors.append(abs(state.dcm - state.dcm_offset - analytic.dcm))
        walker.velocity = (speed if now >= SETTLE else 0.0, 0.0, 0.0)
        stopwatch.periods.append(0.0)

    with Mujoco(robot, seed=0) as plant:
        report = wbc.run(walker, plant, duration, before_tick=before_tick)
    if not report.survived:
        raise SystemExit(f"{name} with planner '{planner}' fell: {report.fell_why}")
    times = 1e6 * np.array(stopwatch.periods)[round(SETTLE / walker.dt) + 1 :]
    return {
        "dcm_error_rms_mm": 1e3 * float(np.sqrt(np.mean(np.square(errors)))),
        "time_p50_us": float(np.median(times)),
        "time_p99_us": float(np.percentile(times, 99)),
        "time_mean_us": float(np.mean(times)),
    }


def survivals(args: argparse.Namespace) -> dict[tuple[str, str], tuple[int, int]]:
    """Push all robots with all planners; return how many trials of how many were survived."""
    grid = Grid(
        robots=tuple(RobotCases(name, (SPEEDS[name],)) for name in args.robot),
        sizes=tuple(args.sizes),
        controllers=tuple(ControllerSpec(name, options={"planner": name}) for name in args.planner),
        phases=3,
        seeds=tuple(range(args.seeds)),
    )
    with tempfile.TemporaryDirectory() as folder, local_workers(args.jobs) as workers:
        results = run_grid(grid, Path(folder) / "planners.parquet", workers)
    counts: dict[tuple[str, str], tuple[int, int]] = {}
    for survival in survival_rates(results.trials):
        key = (survival.case.robot, survival.case.controller)
        survived, trials = counts.get(key, (0, 0))
        counts[key] = (
            survived + sum(rate.survived for rate in survival.rates),
            trials + sum(rate.trials for rate in survival.rates),
        )
    return counts


def main() -> None:
    """Walk and push, print the table, write the JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--robot", nargs="+", choices=sorted(SPEEDS), default=list(SPEEDS), help="robots"
    )
    parser.add_argument(
        "--planner", nargs="+", choices=PLANNER_NAMES, default=list(PLANNER_NAMES), help="planners"
    )
    parser.add_argument("--duration", type=float, default=8.0, help="of a walk, s (default: 8)")
    parser.add_argument(
        "--sizes",
        type=float,
        nargs="*",
        default=[0.3, 0.5],
        help="sizes of the pushes, N·s per kg; none: no pushes (default: 0.3 0.5)",
    )
    parser.add_argument("--seeds", type=int, default=1, help="seeds of the pushes (default: 1)")
    parser.add_argument("--jobs", type=int, help="processes for the pushes (default: one per core)")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    args = parser.parse_args()
    pushes = survivals(args) if args.sizes else {}
    rows = []
    for name in args.robot:
        for planner in args.planner:
            figures = walk(name, planner, SPEEDS[name], args.duration)
            survived, trials = pushes.get((name, planner), (0, 0))
            rows.append(
                {"robot": name, "planner": planner, **figures}
                | ({"pushes": trials, "survived": survived} if trials else {})
            )
    print(table(rows))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def table(rows: list[dict[str, Any]]) -> str:
    """Return a Markdown table with one row per robot and planner."""
    lines = [
        "| robot | planner | DCM error, mm rms | pushes survived | planner per tick, µs "
        "(p50 / p99 / mean) |",
        "| --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        pushes = f"{row['survived']}/{row['pushes']}" if "pushes" in row else "–"
        lines.append(
            f"| {row['robot']} | `{row['planner']}` | {row['dcm_error_rms_mm']:.1f} | {pushes} | "
            f"{row['time_p50_us']:.0f} / {row['time_p99_us']:.0f} / {row['time_mean_us']:.0f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
