"""Measures how steady and how exact the estimated place of a robot is, by the way it has walked.

The robot walks straight ahead at a share of its largest speed and is pushed every 5 s, as in
`benchmarks/random_commands.py`. While it is on one leg, the sole under it stands still: how far the
estimate moves that sole from where it is when the swing begins is what steps, and everything else
that is planned in the world, are disturbed by. Place and heading themselves drift: no sensor
measures them. Noise, estimator and plant are those of `benchmarks/walk.py`.

    python benchmarks/odometry.py                          # Talos and G1, 200 s
    python benchmarks/odometry.py --robot icub --duration 60 --pushes 0
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from shared.random_pushes import PUSHES, RandomPushes, share_of

import wbc
from wbc.gait import Phase
from wbc.geometry.planar import ground_point, wrap_angle
from wbc.robot.attitude import heading
from wbc.sim import Mujoco

_STAND = 0.5  # s of standing at the start
_SHARE = 0.8  # of the largest speed ahead
_BIN = 20.0  # m of way in a row of the table


@dataclass
class Swing:
    """One swing: the way to its support foot, and how far the estimate moves that foot, m."""

    steps: int
    place: complex
    moved: float = 0.0


@dataclass
class Walk:
    """What is measured on one robot.

    Attributes:
        name: of the robot.
        swings: one after the other.
        fell: time of the fall, s; None for none.
        place_error: distance of the estimated place from the true one at the end, m.
        heading_error: the same of the heading, rad.
        way: true distance from the start at the end, m.
    """

    name: str
    swings: list[Swing] = field(default_factory=list)
    fell: float | None = None
    place_error: float = 0.0
    heading_error: float = 0.0
    way: float = 0.0


def walk(job: tuple[str, float, float]) -> Walk:
    """Run one robot; return what is measured."""
    name, duration, share = job
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    result = Walk(name)
    with Mujoco(robot, dt=walker.dt, seed=0) as plant:
        pushes = RandomPushes(plant, share_of(name, share), 0)
        start = ground_point(plant.ground_truth().q)

        def before_tick(time: float) -> None:
            speed = _SHARE * walker.gait.max_velocity.forward if time >= _STAND else 0.0
            walker.velocity = (speed, 0.0, 0.0)
            if share > 0.0:
                pushes(time)
            _observe(walker, result.swings)

        result.fell = wbc.run(walker, plant, duration, before_tick=before_tick).fell_at_s
        truth, estimate = plant.ground_truth(), walker.kinematics.state
        result.place_error = abs(ground_point(estimate.q) - ground_point(truth.q))
        result.heading_error = abs(wrap_angle(heading(robot, estimate) - heading(robot, truth)))
        result.way = abs(ground_point(truth.q) - start)
    return result


def _observe(walker: wbc.Walker, swings: list[Swing]) -> None:
    state = walker.gait_state
    if state.phase is not Phase.SWING:
        return
    place = state.stance.point
    if not swings or swings[-1].steps != state.steps:
        swings.append(Swing(state.steps, place))
    swings[-1].moved = max(swings[-1].moved, abs(place - swings[-1].place))


def print_result(result: Walk) -> bool:
    """Print a robot's table, and where it is at the end; return whether it fell."""
    ways = np.array([abs(swing.place) for swing in result.swings])
    moved = 1e3 * np.array([swing.moved for swing in result.swings])
    print(f"\n{result.name}: how far the estimate moves the sole that stands, in each swing\n")
    print("| way, m | swings | median, mm | 95 %, mm | most, mm |")
    print("| --- | --- | --- | --- | --- |")
    for start in np.arange(0.0, ways.max(), _BIN):
        here = moved[(ways >= start) & (ways < start + _BIN)]
        if here.size:
            median, high = np.percentile(here, [50.0, 95.0])
            print(
                f"| {start:.0f} to {start + _BIN:.0f} | {here.size} | {median:.1f} | {high:.1f} | "
                f"{here.max():.0f} |"
            )
    fell = result.fell is not None
    end = f"It fell after {result.fell:.1f} s" if fell else "It stands at the end"
    print(
        f"\n{end}, {result.way:.0f} m from its start; the estimate is off by "
        f"{result.place_error:.2f} m and {math.degrees(result.heading_error):.1f}°.",
        flush=True,
    )
    return fell


def main() -> int:
    """Run the robots and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot", action="append", choices=PUSHES, help="may be repeated (default: talos, g1)"
    )
    parser.add_argument("--duration", type=float, default=200.0, help="s (default: %(default)s)")
    parser.add_argument(
        "--pushes", type=float, default=0.5, help="share of the sizes to survive; 0: none"
    )
    parser.add_argument("--jobs", type=int, default=1, help="parallel processes")
    args = parser.parse_args()
    jobs = [(name, args.duration, args.pushes) for name in args.robot or ("talos", "g1")]
    with ProcessPoolExecutor(args.jobs) as pool:
        fell = [print_result(result) for result in pool.map(walk, jobs)]
    return 1 if any(fell) else 0


if __name__ == "__main__":
    sys.exit(main())
