"""Shows which punches of the tour at full force fell a robot, and what would have to be different.

Short tours (`wbc trials tour`) whose punches all have their greatest force: how many are survived,
by the part of the body that is hit, by the angular momentum that a punch gives about the vertical,
which only the friction of the soles takes up again, and by the way that it moves the divergent
component of motion (DCM),

    |Δv / ω + ω (L_y, −L_x) / (m g)|,

with the velocity Δv and the angular momentum L that it gives to the robot. How far off the support
sole steps can catch the DCM at all is printed beside it, and how many tours stay within that. After
the plant as it is come the same tours with one thing changed: the torso always held about the
vertical; the state known exactly; ground of four times the friction; legs and waist of twice the
torque and speed; both. The last four show what bounds the controller, they are no results of it.

    python benchmarks/punches.py
    python benchmarks/punches.py --tours 20 --condition as-it-is

Single punches of a kind that a short tour has few of, on one part of the body or upwards:

    python benchmarks/punches.py --part ankles --robot g1_tour --friction 1 --condition as-it-is
    python benchmarks/punches.py --elevation 30 --robot g1_tour --friction 1 --condition as-it-is
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
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

import wbc
from wbc.estimation import GroundTruthEstimator
from wbc.geometry.quintic import PEAK_ACCELERATION
from wbc.robot.upper_body import UpperBody
from wbc.sim import Mujoco
from wbc.trials.tour import Punch, TourParameters, draw_direction, draw_tour, run_tour
from wbc.walking import WalkerGains

_DT = 0.002  # s
_FIRST_SEED = 200
_SEGMENTS = 3  # punches of a tour
_DRAWN = 1000  # tours of 90 s whose punches are counted
_SINGLE = 5.2  # s that a run with a single punch takes
_PUNCHED = 2.2, 2.9  # s, when it comes
_TURNS = 0.0, 2.0, 4.0, math.inf  # kg·m²/s: bounds of the columns
_JUMPS = 0.0, 0.2, 0.3, 0.4, math.inf  # m, the same
_PARTS = "arms", "ankles", "hips, knees, waist"


@dataclass(frozen=True)
class Condition:
    """What differs from the plant and the controller as they are.

    Attributes:
        exact: whether the controller knows the state exactly.
        friction: factor on the Coulomb coefficient of the ground.
        assumed_friction: the same that the controller counts on.
        release_angle: see `WalkerGains.torso_release_angle`.
        strength: factor on torque and velocity limits of legs and waist.
    """

    exact: bool = False
    friction: float = 1.0
    assumed_friction: float = WalkerGains().friction
    release_angle: float = WalkerGains().torso_release_angle
    strength: float = 1.0


@dataclass(frozen=True)
class Plan:
    """What is the same in all conditions.

    Attributes:
        robot: its name.
        part: part of the body that is hit; None: any.
        elevation: least angle of a punch over the ground, rad; None: any direction.
        friction: Coulomb coefficient of the ground.
    """

    robot: str
    part: str | None
    elevation: float | None
    friction: float

    @property
    def single(self) -> bool:
        """Whether there is one punch in a tour, which is chosen."""
        return self.part is not None or self.elevation is not None


CONDITIONS = {
    "as-it-is": Condition(),
    "torso-held": Condition(release_angle=math.inf),
    "exact-state": Condition(exact=True),
    "friction": Condition(exact=True, friction=4.0, assumed_friction=2.4),
    "strength": Condition(exact=True, strength=2.0),
    "both": Condition(exact=True, friction=4.0, assumed_friction=2.4, strength=2.0),
}


@dataclass(frozen=True)
class Outcome:
    """One punch.

    Attributes:
        part: part of the body that was hit.
        turn: angular momentum about the vertical through the CoM, kg·m²/s.
        jump: way by which the DCM moves, m.
        survived: whether the robot stayed on its feet until the next punch.
    """

    part: str
    turn: float
    jump: float
    survived: bool


def tour(plan: Plan, condition: Condition, seed: int) -> list[Outcome]:
    """Run a short tour; return its punches."""
    robot = _load(plan.robot, condition.strength)
    arms = _arm_joints(robot)
    segments, duration = (1, _SINGLE) if plan.single else (_SEGMENTS, 5.0 * _SEGMENTS)
    parameters = TourParameters(duration=duration, waypoints=segments, first_force=1.0)
    drawn = draw_tour(robot, seed, parameters)
    if plan.single:
        (punch,), part = drawn.punches, plan.part
        joints = [j for j in robot.joint_names if part in (None, _part(robot, arms, j))]
        chosen = _aimed_at(punch, joints, plan.elevation, seed)
        drawn = dataclasses.replace(drawn, punches=(chosen,))
    plant = _Observed(
        robot,
        dt=_DT,
        seed=seed,
        ground_truth=condition.exact,
        friction=condition.friction * plan.friction,
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
    return [
        Outcome(_part(robot, arms, punch.joint), turn, jump, punch is not felled)
        for punch, (turn, jump) in zip(hit, plant.effects, strict=True)
    ]


def _aimed_at(punch: Punch, joints: list[str], elevation: float | None, seed: int) -> Punch:
    """Return the punch at one of some joints, at another time: in any phase of the gait.

    With a least elevation, rad, its direction is uniform on that part of the sphere.
    """
    rng = np.random.default_rng((seed, len(joints)))
    joint, time = joints[rng.integers(len(joints))], rng.uniform(*_PUNCHED)
    force = punch.force
    if elevation is not None:
        force = float(np.linalg.norm(force)) * draw_direction(rng, elevation)
    return dataclasses.replace(punch, time=time, joint=joint, force=force)


class _Observed(Mujoco):
    """Notes what each push does: the turn, kg·m²/s, and the jump, m; see `Outcome`."""

    def __init__(self, robot: wbc.Robot, **options: Any) -> None:
        super().__init__(robot, **options)
        self.effects: list[tuple[float, float]] = []

    def push(self, impulse: Any, *, duration: float = 0.1, frame: str | None = None) -> None:
        """See `Mujoco.push`."""
        assert frame is not None
        kin = wbc.Kinematics(self.robot, self.ground_truth())
        self.effects.append(_effect(self.robot, kin, frame, np.asarray(impulse)))
        super().push(impulse, duration=duration, frame=frame)


def _effect(
    robot: wbc.Robot, kin: wbc.Kinematics, frame: str, impulse: np.ndarray
) -> tuple[float, float]:
    """Return the turn, kg·m²/s, and the jump, m, of an impulse (3,), N·s, on a frame's origin."""
    x, y, z = np.cross(kin.frame(frame).translation - kin.p_com, impulse).tolist()
    omega = math.sqrt(robot.gravity / robot.com_height)
    velocity = complex(impulse[0], impulse[1]) / robot.mass
    return abs(z), abs(velocity / omega + omega * complex(y, -x) / robot.weight)


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


def _part(robot: wbc.Robot, arms: set[int], joint: str) -> str:
    index = robot.joint_index(joint)
    if index in arms:
        return "arms"
    ankles = [dof - 6 for leg in robot.legs for dof in leg[-2:]]
    return "ankles" if index in ankles else "hips, knees, waist"


def _share(outcomes: Iterable[Outcome]) -> str:
    survived = [outcome.survived for outcome in outcomes]
    if not survived:
        return "-"
    return f"{sum(survived)}/{len(survived)} {100.0 * float(np.mean(survived)):3.0f} %"


def _rows(name: str, outcomes: list[Outcome]) -> str:
    """Return the lines of a condition: all punches, and by part, turn and jump."""
    parts = [f"{part}: {_share(o for o in outcomes if o.part == part)}" for part in _PARTS]
    turns = _cells(_TURNS, "kg·m²/s", [(o.turn, o) for o in outcomes])
    jumps = _cells(_JUMPS, "m", [(o.jump, o) for o in outcomes])
    lines = [f"{name}: {_share(outcomes)}"]
    for title, cells in (("hit", parts), ("turn", turns), ("DCM", jumps)):
        lines.append(f"    {title:4}  {'   '.join(cells)}")
    return "\n".join(lines)


def _cells(
    bounds: tuple[float, ...], unit: str, outcomes: list[tuple[float, Outcome]]
) -> list[str]:
    """Return the share that is survived between each two bounds of a value."""
    cells = []
    for low, high in itertools.pairwise(bounds):
        name = f"over {low:g}" if math.isinf(high) else f"{low:g} to {high:g}"
        share = _share(outcome for value, outcome in outcomes if low <= value < high)
        cells.append(f"{name} {unit}: {share}")
    return cells


def capturability(robot: wbc.Robot) -> str:
    """Say how far off the support sole's centre steps can catch the DCM, and what that allows.

    Steps of the length L and the duration T, each with the ZMP at the toe, m ahead of the sole's
    centre, leave no less than the one before of a DCM that is farther ahead than

        m + L / (e^(ωT) − 1)

    (N-step capturability, Koolen et al., IJRR 2012). A foot that is accelerated by a at most gets
    2 L ahead in the time T of a quintic of which a is the peak. A DCM beside the sole, where the
    legs are in each other's way, is caught less far off. Tours without a punch that moves the DCM
    of a robot in its standing posture farther are about those that steps alone can complete.
    """
    walker = wbc.Walker(robot, _DT)
    gait, acceleration = walker.recovery_gait, walker.stabilizer.push_recovery.foot_acceleration
    toe = min(sole.half_length for sole in robot.soles)

    def step(duration: float) -> float:
        way = acceleration * duration**2 / PEAK_ACCELERATION
        return min(0.5 * way, gait.max_step)

    def caught(duration: float) -> float:
        return toe + step(duration) / math.expm1(gait.omega * duration)

    best = max(np.linspace(0.1, 0.6, 101).tolist(), key=caught)
    share = acceleration / robot.gravity
    return (
        f"steps catch a DCM that is up to {caught(best):.2f} m ahead of the support sole's centre: "
        f"{step(best):.2f} m long in {best:.2f} s, with feet that get {share:.1f} g;\n"
        f"{100.0 * _share_within(robot, caught(best)):.0f} % of {_DRAWN} tours of 90 s have no "
        "punch that moves it farther"
    )


def _share_within(robot: wbc.Robot, limit: float) -> float:
    """Return the share of tours whose punches all move the DCM by `limit` (m) at most."""
    kin = wbc.Kinematics(robot, robot.standing())
    parameters = TourParameters()
    drawn = (draw_tour(robot, seed, parameters).punches for seed in range(_DRAWN))
    within = [
        all(
            _effect(robot, kin, p.joint, p.force * parameters.punch_duration)[1] <= limit
            for p in punches
        )
        for punches in drawn
    ]
    return float(np.mean(within))


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="g1", help="two legs and two arms, default g1")
    parser.add_argument("--tours", type=int, default=100, help="short tours, default 100")
    parser.add_argument(
        "--condition", choices=CONDITIONS, action="append", help="repeatable; all by default"
    )
    parser.add_argument("--part", choices=_PARTS, help="a single punch per tour, on this part")
    parser.add_argument(
        "--elevation", type=float, metavar="DEG", help="a single one, at least so far upwards"
    )
    parser.add_argument("--friction", type=float, default=0.8, help="of the ground, default 0.8")
    options = parser.parse_args(argv)
    elevation = None
    if options.elevation is not None:
        if not -90.0 <= options.elevation < 90.0:
            parser.error(f"--elevation {options.elevation:g}: give -90 to less than 90 degrees")
        elevation = math.radians(options.elevation)
    plan = Plan(options.robot, options.part, elevation, options.friction)
    print(f"{options.robot}: punches at full force that are survived")
    print(capturability(wbc.load(options.robot)), flush=True)
    start = time.perf_counter()
    seeds = range(_FIRST_SEED, _FIRST_SEED + options.tours)
    with ProcessPoolExecutor() as pool:
        for name in options.condition or CONDITIONS:
            job: Callable[[int], list[Outcome]] = functools.partial(tour, plan, CONDITIONS[name])
            outcomes = [outcome for punches in pool.map(job, seeds) for outcome in punches]
            print(f"\n{_rows(name, outcomes)}", flush=True)
    print(f"\n{time.perf_counter() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
