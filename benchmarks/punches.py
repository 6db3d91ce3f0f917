"""Shows which punches of the tour at full force fell a robot, and what would have to be different.

Short tours (`wbc trials tour`) whose punches all have their greatest force: how many are survived,
by the part of the body that is hit and by the angular momentum that a punch gives about the
vertical, which only the friction of the soles takes up again. Beside the plant as it is, the same
tours with one thing changed: the torso always held about the vertical; the state known exactly;
ground of four times the friction; legs and waist of twice the torque and speed. The last three show
what bounds the controller, they are no results of it.

    python benchmarks/punches.py
    python benchmarks/punches.py --tours 20 --condition as-it-is
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import dataclasses
import functools
import itertools
import math
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

import wbc
from wbc.estimation import GroundTruthEstimator
from wbc.robot.upper_body import UpperBody
from wbc.sim import Mujoco
from wbc.trials.tour import Punch, TourParameters, draw_tour, run_tour
from wbc.walking import WalkerGains

_DT = 0.002  # s
_FIRST_SEED = 200
_SEGMENTS = 3  # punches of a tour
_TURNS = 0.0, 2.0, 4.0, math.inf  # kg·m²/s: bounds of the columns
_PARTS = "arms", "ankles", "hips, knees, waist"
_TITLES = "all", *_PARTS, "turn 0 to 2", "turn 2 to 4", "turn over 4"


@dataclass(frozen=True)
class Condition:
    """What differs from the plant and the controller as they are.

    Attributes:
        exact: whether the controller knows the state exactly.
        friction: Coulomb coefficient of the ground.
        assumed_friction: the same that the controller counts on.
        release_angle: see `WalkerGains.torso_release_angle`.
        strength: factor on torque and velocity limits of legs and waist.
    """

    exact: bool = False
    friction: float = 0.8
    assumed_friction: float = WalkerGains().friction
    release_angle: float = WalkerGains().torso_release_angle
    strength: float = 1.0


CONDITIONS = {
    "as-it-is": Condition(),
    "torso-held": Condition(release_angle=math.inf),
    "exact-state": Condition(exact=True),
    "friction": Condition(exact=True, friction=3.2, assumed_friction=2.4),
    "strength": Condition(exact=True, strength=2.0),
}


@dataclass(frozen=True)
class Outcome:
    """One punch.

    Attributes:
        part: part of the body that was hit.
        turn: angular momentum about the vertical through the CoM, kg·m²/s.
        survived: whether the robot stayed on its feet until the next punch.
    """

    part: str
    turn: float
    survived: bool


def tour(name: str, condition: Condition, seed: int) -> list[Outcome]:
    """Run a short tour; return its punches."""
    robot = _load(name, condition.strength)
    parameters = TourParameters(duration=5.0 * _SEGMENTS, waypoints=_SEGMENTS, first_force=1.0)
    drawn = draw_tour(robot, seed, parameters)
    plant = _Observed(
        robot,
        dt=_DT,
        seed=seed,
        ground_truth=condition.exact,
        friction=condition.friction,
    )
    gains = dataclasses.replace(
        WalkerGains.for_robot(robot),
        friction=condition.assumed_friction,
        torso_release_angle=condition.release_angle,
    )
    estimator = GroundTruthEstimator(robot) if condition.exact else None
    walker = wbc.Walker(robot, _DT, gains=gains)
    result = run_tour(robot, walker, drawn, plant=plant, estimator=estimator)
    hit = [punch for punch in drawn.punches if punch.time <= result.survived]
    felled = None if result.completed else hit[-1]
    arms = _arm_joints(robot)
    return [
        Outcome(_part(robot, arms, punch), turn, punch is not felled)
        for punch, turn in zip(hit, plant.turns, strict=True)
    ]


class _Observed(Mujoco):
    """Notes the angular momentum that each push gives about the vertical, kg·m²/s."""

    def __init__(self, robot: wbc.Robot, **options: Any) -> None:
        super().__init__(robot, **options)
        self.turns: list[float] = []

    def push(self, impulse: Any, *, duration: float = 0.1, frame: str | None = None) -> None:
        """See `Mujoco.push`."""
        assert frame is not None
        kin = wbc.Kinematics(self.robot, self.ground_truth())
        arm = kin.frame(frame).translation - kin.p_com
        self.turns.append(abs(float(np.cross(arm, impulse)[2])))
        super().push(impulse, duration=duration, frame=frame)


def _load(name: str, strength: float) -> wbc.Robot:
    """Load a robot whose legs and waist have a multiple of their torque and velocity limits."""
    robot = wbc.load(name)
    if strength == 1.0:
        return robot
    arms = _arm_joints(robot)
    joints = [i for i in range(robot.na) if i not in arms]
    velocity = robot.model.velocityLimit[6:]
    return wbc.load(
        name,
        effort_limits={robot.joint_names[i]: strength * float(robot.tau_max[i]) for i in joints},
        velocity_limits={robot.joint_names[i]: strength * float(velocity[i]) for i in joints},
    )


def _arm_joints(robot: wbc.Robot) -> set[int]:
    return {index for arm in UpperBody.of(robot).arms for index in arm.joints}


def _part(robot: wbc.Robot, arms: set[int], punch: Punch) -> str:
    index = robot.joint_index(punch.joint)
    if index in arms:
        return "arms"
    ankles = [dof - 6 for leg in robot.legs for dof in leg[-2:]]
    return "ankles" if index in ankles else "hips, knees, waist"


def _share(outcomes: Iterable[Outcome]) -> str:
    survived = [outcome.survived for outcome in outcomes]
    if not survived:
        return "-"
    return f"{sum(survived)}/{len(survived)} {100.0 * float(np.mean(survived)):3.0f} %"


def _row(name: str, outcomes: list[Outcome]) -> str:
    cells = [_share(outcomes)]
    cells += [_share(o for o in outcomes if o.part == part) for part in _PARTS]
    cells += [
        _share(o for o in outcomes if least <= o.turn < most)
        for least, most in itertools.pairwise(_TURNS)
    ]
    return _line(name, cells)


def _line(name: str, cells: Sequence[str]) -> str:
    return f"{name:11}" + "".join(
        f"  {cell:>{max(len(title), 13)}}" for title, cell in zip(_TITLES, cells, strict=True)
    )


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="g1", help="two legs and two arms, default g1")
    parser.add_argument("--tours", type=int, default=100, help="short tours, default 100")
    parser.add_argument(
        "--condition", choices=CONDITIONS, action="append", help="repeatable; all by default"
    )
    options = parser.parse_args(argv)
    print(f"{options.robot}: punches at full force that are survived; turn in kg·m²/s")
    print(_line("condition", _TITLES))
    start = time.perf_counter()
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.tours)
    with ProcessPoolExecutor() as pool:
        for name in options.condition or CONDITIONS:
            job: Callable[[int], list[Outcome]] = functools.partial(
                tour, options.robot, CONDITIONS[name]
            )
            outcomes = [outcome for punches in pool.map(job, seeds) for outcome in punches]
            print(_row(name, outcomes), flush=True)
    print(f"{time.perf_counter() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
