"""Simulates random velocity commands within and at the limits of each robot's gait.

Each command is held for 1 to 4 s and drawn from the set of velocities that the gait takes: half of
them uniformly inside it, half of them at its border. A run ends with the fall or with the time.
Noise, estimator and plant are those of `benchmarks/walk.py`.

With `--pushes SHARE` the torso is pushed every 5 s for 0.1 s, in a random direction, by that share
of the size that each robot is to survive there while it walks (`shared.random_pushes.PUSHES`).

    python benchmarks/random_commands.py                   # all robots, one minute, 3 seeds
    python benchmarks/random_commands.py --robot romeo --duration 600 --seeds 1 --pushes 0.5
    python benchmarks/random_commands.py --pushes 0.5 --sizes-of romeo \
        --robot benchmarks/grids/robots/romeo_strong_legs.toml    # what bounds Romeo
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
from shared.random_pushes import PUSHES, RandomPushes, share_of

import wbc
from wbc.sim import Mujoco

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


def trial(job: tuple[str, int, float, tuple[float, float, float] | None]) -> tuple[wbc.Report, str]:
    """Run one robot; return its report, and the last command and push before its end."""
    name, seed, duration, sizes = job
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    with Mujoco(robot, dt=walker.dt, seed=seed) as plant:
        command = RandomCommands(walker, seed)
        push = None if sizes is None else RandomPushes(plant, sizes, seed)

        def before_tick(time: float) -> None:
            command(time)
            if push is not None:
                push(time)

        report = wbc.run(walker, plant, duration, before_tick=before_tick)
    velocity = ", ".join(f"{component:.2f}" for component in walker.velocity)
    return report, f"told ({velocity}), last push {push.last if push else 'none'}"


def main() -> int:
    """Run the trials, print the table, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot",
        action="append",
        metavar="NAME|FILE",
        help=f"robot to run; may be repeated (default: {', '.join(PUSHES)})",
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
    parser.add_argument(
        "--pushes",
        type=float,
        default=0.0,
        metavar="SHARE",
        help="also push every 5 s, by this share of the sizes to survive (default: none)",
    )
    parser.add_argument(
        "--sizes-of",
        choices=PUSHES,
        help="push with the sizes of this robot (default: those of the robot itself)",
    )
    parser.add_argument("--json", type=Path, help="write all reports to this file")
    args = parser.parse_args()
    names = args.robot or list(PUSHES)
    sizes = {}
    for name in names if args.pushes > 0.0 else ():
        if (args.sizes_of or name) not in PUSHES:
            parser.error(f"--robot {name}: give --sizes-of, one of {', '.join(PUSHES)}")
        sizes[name] = share_of(args.sizes_of or name, args.pushes)
    jobs = [
        (name, seed, args.duration, sizes.get(name)) for name in names for seed in range(args.seeds)
    ]
    print("| robot | seed | time to fall, s | DCM error, mm rms | steps | before the fall |")
    print("| --- | --- | --- | --- | --- | --- |")
    rows = []
    with ProcessPoolExecutor(args.jobs) as pool:
        for (name, seed, *_), (report, last) in zip(jobs, pool.map(trial, jobs), strict=True):
            fell = report.fell_at_s is not None
            fall = f"{report.fell_at_s:.1f}" if fell else "none"
            print(
                f"| {Path(name).stem} | {seed} | {fall} | {report.dcm_error_rms_mm:.1f} | "
                f"{report.steps} | {last if fell else ''} |",
                flush=True,
            )
            rows.append({"seed": seed, **asdict(report)})
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 1 if any(row["fell_at_s"] is not None for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
