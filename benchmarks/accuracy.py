"""Measures how exactly each robot does what it is told: velocities, turns and places.

Velocities: the mean over whole gait cycles of a steady walk, in each direction, at a share of the
gait's limits, against the command. Turns and places: the robot follows a waypoint by what it
estimates itself, stops, and is measured where it stands, against the true place where it began.
Noise, estimator and plant are those of `benchmarks/walk.py`.

    python benchmarks/accuracy.py                         # all robots, 2 seeds
    python benchmarks/accuracy.py --robot g1 --what places --seeds 5
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import cmath
import itertools
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

import wbc
from wbc.estimation import Estimator
from wbc.gait import Phase, Placement
from wbc.geometry.planar import ground_point, wrap_angle, yaw_of
from wbc.robot.fall import fall_reason
from wbc.sim import Mujoco
from wbc.trials.closed_loop import ClosedLoop
from wbc.walking import WaypointFollower

ROBOTS = ("talos", "g1", "simple_humanoid", "icub", "romeo")
DIRECTIONS = {
    "forward": (1.0, 0.0, 0.0),
    "backward": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "turn": (0.0, 0.0, 1.0),
}
SHARES = (0.5, 1.0)
_WARM_UP, _CYCLES = 4, 3  # gait cycles before the measurement, and of it
_TURNS = (0.5 * math.pi, -0.5 * math.pi, math.pi)  # rad
_PLACES = 4  # per seed, on a disc of 1 m
_MAX_TIME = 60.0  # s for one of them


@dataclass(frozen=True, slots=True)
class Measurement:
    """One figure.

    Attributes:
        robot: name.
        what: the command.
        error: relative error of a velocity, distance from a place, m, or from a heading, rad.
        fall: why the robot fell; empty if it did not.
    """

    robot: str
    what: str
    error: float
    fall: str = ""


class Trial:
    """A walker in closed loop, and where it truly is.

    Args:
        name: of the robot.
        seed: of the noise.
    """

    def __init__(self, name: str, seed: int) -> None:
        self.robot = robot = wbc.load(name)
        self.walker = walker = wbc.Walker(robot)
        plant = Mujoco(robot, dt=walker.dt, seed=seed)
        self._loop = ClosedLoop(robot, plant, Estimator(robot, walker.dt), walker)
        self._loop.reset()
        self._truth = wbc.Kinematics(robot, robot.standing())
        self.fall = ""
        self._ticks = 0

    @property
    def time(self) -> float:
        """Since the start, s."""
        return self._ticks * self.walker.dt

    def tick(self) -> None:
        """One control period."""
        self._loop.tick()
        self._ticks += 1
        if self._ticks % 10 == 0 and not self.fall:
            self.fall = fall_reason(self.robot, self._loop.plant.ground_truth())

    def run(self, seconds: float) -> None:
        """Go on for a time, or until the fall."""
        for _ in range(round(seconds / self.walker.dt)):
            if self.fall:
                return
            self.tick()

    def true_place(self) -> Placement:
        """Midway between the true soles, with their mean heading."""
        self._truth.update(self._loop.plant.ground_truth())
        left, right = (self._truth.frame(sole.name) for sole in self.robot.soles)
        middle = 0.5 * (ground_point(left.translation) + ground_point(right.translation))
        one, other = yaw_of(left.rotation), yaw_of(right.rotation)
        return Placement(middle, one + 0.5 * wrap_angle(other - one))


def velocity_error(job: tuple[str, int, str, float]) -> Measurement:
    """Walk at a share of a limit; return the relative error of the velocity."""
    name, seed, direction, share = job
    trial = Trial(name, seed)
    walker = trial.walker
    limits = walker.gait.max_velocity
    along = np.array(DIRECTIONS[direction])
    most = limits.clamp(*(1e6 * along))
    told = share * math.sqrt(sum(v * v for v in most))
    what = f"{direction} {told:.2f}"
    trial.run(0.5)
    walker.velocity = tuple(share * v for v in most)
    marks: list[tuple[float, Placement]] = []
    steps = 0
    while len(marks) <= _WARM_UP + _CYCLES and not trial.fall:
        trial.tick()
        if walker.steps != steps:
            steps = walker.steps
            if steps % 2 == 0:
                marks.append((trial.time, trial.true_place()))
    if trial.fall:
        return Measurement(name, what, math.inf, trial.fall)
    moved = [after[1].relative_to(before[1]) for before, after in itertools.pairwise(marks)]
    steady = moved[_WARM_UP:]
    time = marks[-1][0] - marks[-1 - len(steady)][0]
    way = sum(((m.point.real, m.point.imag, m.yaw) @ along for m in steady), 0.0)
    return Measurement(name, what, way / time / told - 1.0)


def waypoint_errors(job: tuple[str, int, str]) -> list[Measurement]:
    """Walk to turns or places one after the other; return the errors where the robot stands."""
    name, seed, what = job
    trial = Trial(name, seed)
    walker = trial.walker
    trial.run(0.5)
    rows: list[Measurement] = []
    for goal in _goals(what, seed):
        start, true_start = walker.stopping_place, trial.true_place()
        target = start.compose(goal)
        follower = WaypointFollower.for_gait(walker.gait)
        end = trial.time + _MAX_TIME
        standing = 0
        while not trial.fall and trial.time < end and standing < 250:
            walker.velocity = follower.velocity(target, walker.stopping_place)
            trial.tick()
            standing = standing + 1 if walker.gait_state.phase is Phase.STAND else 0
        error = goal.relative_to(trial.true_place().relative_to(true_start))
        late = "" if trial.fall or trial.time < end else f"not there after {_MAX_TIME:g} s"
        rows.append(Measurement(name, f"{what}: m", abs(error.point), trial.fall or late))
        rows.append(Measurement(name, f"{what}: rad", abs(error.yaw), trial.fall or late))
        if trial.fall:
            break
    return rows


def _goals(what: str, seed: int) -> list[Placement]:
    if what == "turns":
        return [Placement(0j, yaw) for yaw in _TURNS]
    random = np.random.default_rng(seed)
    return [
        Placement(
            cmath.rect(math.sqrt(random.random()), random.uniform(0.0, math.tau)),
            float(random.uniform(-math.pi, math.pi)),
        )
        for _ in range(_PLACES)
    ]


def main() -> int:
    """Run the measurements and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot",
        action="append",
        choices=ROBOTS,
        help="robot to run; may be repeated (default: all)",
    )
    parser.add_argument(
        "--what",
        action="append",
        choices=("velocities", "turns", "places"),
        help="what to measure; may be repeated (default: all)",
    )
    parser.add_argument(
        "--seeds", type=int, default=2, help="runs per figure (default: %(default)s)"
    )
    parser.add_argument(
        "--jobs", type=int, default=1, help="parallel processes (default: %(default)s)"
    )
    args = parser.parse_args()
    robots, seeds = args.robot or ROBOTS, range(args.seeds)
    what = args.what or ("velocities", "turns", "places")
    failed = False
    with ProcessPoolExecutor(args.jobs) as pool:
        if "velocities" in what:
            jobs = [(n, s, d, x) for n in robots for d in DIRECTIONS for x in SHARES for s in seeds]
            print("| robot | told, m/s or rad/s | error, % (each seed) |\n| --- | --- | --- |")
            cells: dict[tuple[str, str], list[str]] = {}
            for row in pool.map(velocity_error, jobs):
                failed |= abs(row.error) > 0.05
                cell = row.fall or f"{100.0 * row.error:+.1f}"
                cells.setdefault((row.robot, row.what), []).append(cell)
            for (name, command), errors in cells.items():
                print(f"| {name} | {command} | {', '.join(errors)} |", flush=True)
        for kind in ("turns", "places"):
            if kind not in what:
                continue
            print(f"\n| robot | {kind}, largest error: cm | ° | runs | falls |")
            print("| --- | --- | --- | --- | --- |")
            for name in robots:
                rows = [
                    r
                    for some in pool.map(waypoint_errors, [(name, s, kind) for s in seeds])
                    for r in some
                ]
                off = max(r.error for r in rows if r.what.endswith(" m"))
                turned = max(r.error for r in rows if r.what.endswith("rad"))
                falls = {r.fall for r in rows if r.fall}
                failed |= bool(falls) or off > 0.05 or turned > math.radians(5.0)
                print(
                    f"| {name} | {100.0 * off:.1f} | {math.degrees(turned):.1f} | "
                    f"{len(rows) // 2} | {'; '.join(falls) or 'none'} |",
                    flush=True,
                )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
