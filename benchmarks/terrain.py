"""Walks robots over ground that they cannot see, and over stones and stairs with footsteps given.

Every run is in MuJoCo with noisy sensors, the estimator in the loop, colliding limbs and the URDF's
torque limits. Unseen ground is crossed at a velocity: tiles of random height, a slope up and down,
soft ground, a slippery patch. On stones and stairs the footsteps are given, as a planner would find
them; between stones the floor is deeper than a foot is lifted. A run passes if the robot survives
and gets across.

    python benchmarks/terrain.py
    python benchmarks/terrain.py --robot g1 --terrain slope --seeds 2
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

import wbc
from wbc.sim import Mujoco, Ramp, SlipperyPatch, Staircase, Terrain, Tiles
from wbc.telemetry import Footstep

ROBOTS = ("talos", "g1", "simple_humanoid")
#: Of each robot. Talos's are those of Caron, Kheddar and Tempier, Stair climbing stabilization of
#: the HRP-4 humanoid robot using whole-body admittance control, ICRA 2019.
RISERS = {
    "talos": (0.185, 0.185, 0.185, 0.185, 0.145),
    "g1": (0.08, 0.08, 0.08),
    "simple_humanoid": (0.1, 0.1, 0.1),
}
_STAND = 1.0  # s before the first step


@dataclass(frozen=True)
class Course:
    """What is walked on, and how.

    Attributes:
        terrain: the ground.
        speed: commanded, m/s; 0 if footsteps are given.
        goal: distance that counts as across, m.
        footsteps: given footsteps.
        sink: depth to which the standing robot sinks into the ground, m.
        slow: whether the steps take as long as on high stairs.
    """

    terrain: Terrain
    speed: float
    goal: float
    footsteps: tuple[Footstep, ...] = ()
    sink: float = 0.0
    slow: bool = False


@dataclass(frozen=True)
class Stones:
    """Stones on the floor, each for one foot.

    Attributes:
        places: (x, y, z) of the top of each, (n, 3), m.
        half_length: of each stone, m.
        half_width: of each stone, m.
    """

    places: np.ndarray
    half_length: float
    half_width: float

    def boxes(self) -> np.ndarray:
        """Return centre and half sizes of the stones, (n, 6), m."""
        n, half = len(self.places), 0.5 * (self.places[:, 2] + 0.1)
        middle = self.places[:, 2] - half
        size = np.tile((self.half_length, self.half_width), (n, 1))
        return np.column_stack((self.places[:, :2], middle, size, half))


def tiles(walker: wbc.Walker, seed: int) -> Course:
    """Tiles of up to 30 mm, 0.4 m wide, for 3 m."""
    return Course(Tiles(height=0.03, seed=seed), 0.3, 3.0)


def slope(walker: wbc.Walker, seed: int) -> Course:
    """2 m up, 1 m level and 2 m down at 10°; so wide that nobody walks off its side."""
    ramp = Ramp(math.radians(10.0), width=12.0)
    return Course(ramp, 0.3, ramp.distance + ramp.plateau + 2.0 * ramp.length)


def soft(walker: wbc.Walker, seed: int) -> Course:
    """Ground that gives way by 10 mm under the standing robot."""
    return Course(wbc.sim.Flat(), 0.3, 2.5, sink=0.01)


def slippery(walker: wbc.Walker, seed: int) -> Course:
    """A patch of 2 m with friction 0.3."""
    patch = SlipperyPatch(0.3)
    return Course(patch, 0.3, patch.distance + patch.length)


def stones(walker: wbc.Walker, seed: int) -> Course:
    """Ten stones of random height, distance and offset, 3 cm larger than a sole on each side."""
    robot, rng = walker.robot, np.random.default_rng(seed)
    sole = robot.soles[0]
    start, half = walker.feet.middle.real, 0.5 * walker.gait.step_width
    x, height = start + 2.0 * sole.half_length + 0.08, 0.0
    places = []
    for k in range(10):
        height = float(np.clip(height + rng.uniform(-0.03, 0.03), 0.0, 0.12)) if k else 0.04
        y = (half + rng.uniform(0.0, 0.03)) * (1.0 if k % 2 == 0 else -1.0)
        places.append((x, y, height))
        # Stones of one side must not meet, and a step is to be within easy reach.
        x += max(sole.half_length + 0.04, 0.1) + rng.uniform(0.0, 0.06)
    last = places[-1]
    steps = [*places, (last[0] + 0.3, half, 0.0), (last[0] + 0.3, -half, 0.0)]
    terrain = Stones(np.array(places), sole.half_length + 0.03, sole.half_width + 0.03)
    return Course(terrain, 0.0, last[0] - start + 0.2, _footsteps(steps))


def stairs(walker: wbc.Walker, seed: int) -> Course:
    """Stairs up to a landing and down again, both feet on each."""
    robot = walker.robot
    distance = robot.soles[0].half_length + 0.08
    terrain = Staircase(RISERS[robot.name], tread=0.25, landing=0.6, distance=distance)
    start, half = walker.feet.middle.real, 0.5 * walker.gait.step_width
    places = terrain.footholds()
    steps = [(start + x, y, z) for x, z in places for y in (half, -half)]
    return Course(terrain, 0.0, places[-1, 0] - 0.1, _footsteps(steps), slow=True)


def _footsteps(places: list[tuple[float, float, float]]) -> tuple[Footstep, ...]:
    """Footsteps at places, m, left and right in turn."""
    return tuple(
        Footstep("left" if k % 2 == 0 else "right", np.array(place), 0.0)
        for k, place in enumerate(places)
    )


COURSES: dict[str, Callable[[wbc.Walker, int], Course]] = {
    "tiles": tiles,
    "slope": slope,
    "soft": soft,
    "slippery": slippery,
    "stones": stones,
    "stairs": stairs,
}


@dataclass(frozen=True)
class Result:
    """One run.

    Attributes:
        robot: name of the robot.
        terrain: name of the course.
        seed: of noise and terrain.
        passed: whether it survived and got across.
        way: distance ahead, m.
        torque: largest share of any torque limit.
        quick: share of the ticks in quick steps.
        qp_failures: ticks whose QP had no solution.
        reason: why it failed; else empty.
    """

    robot: str
    terrain: str
    seed: int
    passed: bool
    way: float
    torque: float
    quick: float
    qp_failures: int
    reason: str


def cross(job: tuple[str, str, int]) -> Result:
    """Run one trial."""
    name, terrain, seed = job
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    course = COURSES[terrain](walker, seed)
    if course.slow:
        walker.change_gait(replace(walker.gait, single_support=0.8, double_support=0.5))
    if course.footsteps:
        walking = (len(course.footsteps) + 2) * walker.gait.step_duration
    else:
        walking = 1.3 * course.goal / course.speed + 2.0  # feet slip
    quick = []

    def before_tick(now: float) -> None:
        quick.append(walker.gait_state.is_quick)
        if course.footsteps:
            if now == 0.0:
                walker.follow(course.footsteps)
        else:
            walker.velocity = (course.speed if _STAND <= now < _STAND + walking else 0.0, 0.0, 0.0)

    with Mujoco(robot, terrain=course.terrain, ground_sink=course.sink, seed=seed) as plant:
        report = wbc.run(walker, plant, _STAND + walking + 2.0, before_tick=before_tick)
    way = report.displacement_m[0]
    reason = report.fell_why
    if not reason and way < course.goal:
        reason = f"got {way:.2f} m of {course.goal:.2f} m"
    torque, share = report.torque_peak_ratio, sum(quick) / len(quick)
    failures = report.qp_failures
    return Result(name, terrain, seed, not reason, way, torque, share, failures, reason)


def main() -> int:
    """Run the trials and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", action="append", choices=ROBOTS, help="may be repeated")
    parser.add_argument("--terrain", action="append", choices=COURSES, help="may be repeated")
    parser.add_argument("--seeds", type=int, default=5, help="per cell (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="parallel processes")
    parser.add_argument("--json", type=Path, help="write all results to this file")
    args = parser.parse_args()
    robots, courses = args.robot or list(ROBOTS), args.terrain or list(COURSES)
    jobs = [(r, t, seed) for r in robots for t in courses for seed in range(args.seeds)]
    results, begin = [], time.perf_counter()
    with ProcessPoolExecutor(args.jobs) as pool:
        for one in pool.map(cross, jobs):
            results.append(one)
            print(
                f"{'ok  ' if one.passed else 'FAIL'} {one.robot:16} {one.terrain:9} "
                f"seed {one.seed}  {one.way:5.2f} m  quick {one.quick:.0%}  {one.reason[:80]}",
                file=sys.stderr,
                flush=True,
            )
    print(table(results))
    print(f"\n{len(jobs)} runs in {time.perf_counter() - begin:.0f} s")
    if args.json:
        rows = json.dumps([asdict(one) for one in results], indent=1)
        args.json.write_text(rows + "\n", encoding="utf-8")
    return 0 if all(one.passed for one in results) else 1


def table(results: list[Result]) -> str:
    """Return a Markdown table: runs that passed, the share of quick ticks, QPs that failed."""
    courses = list(dict.fromkeys(one.terrain for one in results))
    lines = [f"| | {' | '.join(courses)} |", f"| --- |{' --- |' * len(courses)}"]
    for robot in dict.fromkeys(one.robot for one in results):
        cells = []
        for terrain in courses:
            own = [one for one in results if (one.robot, one.terrain) == (robot, terrain)]
            cell = f"{sum(one.passed for one in own)}/{len(own)}"
            quick = sum(one.quick for one in own) / len(own)
            failures = sum(one.qp_failures for one in own)
            cell += f", {quick:.0%} quick" if quick >= 0.005 else ""
            cells.append(cell + (f", {failures} QP" if failures else ""))
        lines.append(f"| {robot} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
