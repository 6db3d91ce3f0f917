"""Simulates random velocity commands within and at the limits of each robot's gait.

Each command is held for 1 to 4 s and drawn from the set of velocities that the gait takes: half of
them uniformly inside it, half of them at its border. A run ends with the fall or with the time.
Noise, estimator and plant are those of `benchmarks/walk.py`.

    python benchmarks/random_commands.py                   # all robots, one minute, 3 seeds
    python benchmarks/random_commands.py --robot romeo --duration 600 --seeds 1
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import numpy as np

import wbc
from wbc.sim import Mujoco

ROBOTS = ("talos", "g1", "simple_humanoid", "icub", "romeo")
_HOLD = (1.0, 4.0)  # s
_STAND = 0.5  # s of standing at the start


class RandomCommands:
    """Sets random velocities of a walker.

    Args:
        walker: the walker.
        seed: of the commands.
    """

    def __init__(self, walker: wbc.Walker, seed: int) -> None:
        self._walker = walker
        self._random = np.random.default_rng(seed)
        self._next = _STAND

    def __call__(self, time: float) -> None:
        """Set another velocity when it is time; call it before each tick."""
        if time < self._next:
            return
        random, limits = self._random, self._walker.gait.max_velocity
        direction = random.normal(size=3)
        direction *= limits.largest / np.linalg.norm(direction)
        border = direction / limits.usage(*direction)
        inside = random.random() ** (1.0 / 3.0)  # uniform in the volume
        share = 1.0 if random.random() < 0.5 else inside
        self._walker.velocity = limits.clamp(*(share * border))
        self._next += random.uniform(*_HOLD)


def trial(job: tuple[str, int, float]) -> wbc.Report:
    """Run one robot."""
    name, seed, duration = job
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    with Mujoco(robot, dt=walker.dt, seed=seed) as plant:
        return wbc.run(walker, plant, duration, before_tick=RandomCommands(walker, seed))


def main() -> int:
    """Run the trials, print the table, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot",
        action="append",
        choices=ROBOTS,
        help="robot to run; may be repeated (default: all)",
    )
    parser.add_argument(
        "--duration", type=float, default=60.0, help="duration of a run, s (default: %(default)s)"
    )
    parser.add_argument(
        "--seeds", type=int, default=3, help="runs per robot (default: %(default)s)"
    )
    parser.add_argument(
        "--jobs", type=int, default=1, help="parallel processes (default: %(default)s)"
    )
    parser.add_argument("--json", type=Path, help="write all reports to this file")
    args = parser.parse_args()
    jobs = [
        (name, seed, args.duration) for name in args.robot or ROBOTS for seed in range(args.seeds)
    ]
    print("| robot | seed | time to fall, s | DCM error, mm rms | steps |")
    print("| --- | --- | --- | --- | --- |")
    rows = []
    with ProcessPoolExecutor(args.jobs) as pool:
        for (name, seed, _), report in zip(jobs, pool.map(trial, jobs), strict=True):
            fall = f"{report.fell_at_s:.1f}" if report.fell_at_s is not None else "none"
            print(
                f"| {name} | {seed} | {fall} | {report.dcm_error_rms_mm:.1f} | {report.steps} |",
                flush=True,
            )
            rows.append({"seed": seed, **asdict(report)})
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 1 if any(row["fell_at_s"] is not None for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
