"""Inverse kinematics: time of a step beside pink, mink and placo, and how much `reach` solves.

`step`: Talos holds both feet by equalities, and follows CoM, both hands (poses) and a posture by
weights, along a motion; every library gets the same configurations, targets, weights and gains
(the whole error in one step) and limits on positions and velocities. Times are CPU times of the
whole call that a user writes, configuration and targets included, in turns of the libraries. "off"
is the largest difference to our joint velocities relative to the largest of them; pink and mink
weigh errors of poses along the axes of the frame, which differs by their square.

`reach`: the protocol of Beeson and Ames, TRAC-IK (Humanoids 2015): random joint positions within
the limits, of which the pose of the hand is the target; start from the middle of the ranges,
tolerance 1e-5 m and rad in each direction. `--start random` starts from other random positions.

`random`: the case of https://github.com/stephane-caron/pink/issues/59, which reports about half of
the poses unsolved: each time another random arm with six joints, from one random posture to the
pose of another one. The same from one start only, and, where it is installed, with steps of pink as
its README shows them, of 10 ms for 20 s at most, tell what the restarts are worth.

    python benchmarks/ik.py step
    python benchmarks/ik.py reach --samples 1000
    python benchmarks/ik.py random --samples 200

The peers come with  pip install placo  and  pip install --no-deps pin-pink mink loop-rate-limiters
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from peers.robot_file import urdf_text
from shared.random_arms import HAND as ARMS_HAND
from shared.random_arms import random_arm

import wbc
from wbc.robot import RobotModel
from wbc.robot.upper_body import UpperBody

DT, PERIOD = 0.002, 10.0  # s, of a step and of the motion
COM, HAND, POSTURE = 100.0, 100.0, 1e-2  # weights
FEET = ("left_sole", "right_sole")
CHAINS = ("talos", "g1", "romeo", "panda", "ur5")
TOLERANCE = 1e-5  # m, rad
PINK_DT, PINK_STEPS = 0.01, 2000  # s
#: Solve rates of 10,000 samples as published in the paper, for arms of humanoids and of industry.
PUBLISHED = "TRAC-IK 99.6 to 100 % in 0.4 to 1 ms; KDL 21 to 98 %"


@dataclass(frozen=True)
class Sample:
    """A configuration and targets near what it has.

    Attributes:
        q: (nq,).
        com: (3,) m.
        hands: poses of the two hands.
        feet: present poses of the two soles.
    """

    q: np.ndarray
    com: np.ndarray
    hands: tuple[pin.SE3, pin.SE3]
    feet: tuple[pin.SE3, pin.SE3]


def samples(robot: wbc.Robot, hands: Sequence[str], count: int) -> list[Sample]:
    """Return the configurations and targets of a motion: hands on circles, CoM on a line."""
    model, data, q = robot.model, robot.model.createData(), robot.q_nominal.copy()
    pin.framesForwardKinematics(model, data, q)
    starts = [data.oMf[robot.frame_id(hand)].copy() for hand in hands]
    feet = tuple(data.oMf[robot.frame_id(foot)].copy() for foot in FEET)
    com = pin.centerOfMass(model, data, q).copy()
    ours, found = Wbc(robot, hands), []
    for k in range(count):
        angle = 2.0 * np.pi * k * DT / PERIOD
        circle = 0.05 * np.array([1.0 - np.cos(angle), np.sin(angle), 0.5 * np.sin(2.0 * angle)])
        turn = pin.exp3(np.array([0.0, 0.1, 0.1]) * np.sin(angle))
        left, right = (pin.SE3(T.rotation @ turn, T.translation + circle) for T in starts)
        shift = 0.02 * np.sin(angle) * np.array([0.2, 1.0, -0.5])
        found.append(Sample(q, com + shift, (left, right), feet))
        v = np.zeros(robot.nv)
        v[:] = ours.velocity(found[-1])
        q = pin.integrate(model, q, DT * v)
    return found


class Wbc:
    """`wbc.InverseKinematics`."""

    label = "wbc"

    def __init__(self, robot: wbc.Robot, hands: Sequence[str]) -> None:
        limits = [
            wbc.JointPositionLimit(robot, margin=0.0, braking=np.inf),
            wbc.JointVelocityLimit(robot),
        ]
        gain = {"kp": 1.0 / DT, "kd": 1.0}
        self._ik = ik = wbc.InverseKinematics(robot, limits=limits, damping=1e-9)
        self._feet = [ik.add(wbc.FrameTask(foot, priority=0, **gain)) for foot in FEET]
        self._com = ik.add(wbc.ComTask(weight=COM, **gain))
        self._hands = [ik.add(wbc.FrameTask(hand, weight=HAND, **gain)) for hand in hands]
        ik.add(wbc.PostureTask(robot, weight=POSTURE, **gain))

    def step(self, sample: Sample) -> np.ndarray:
        """Return the joint velocities (na,)."""
        for task, target in zip(self._feet, sample.feet, strict=True):
            task.target = target
        for task, target in zip(self._hands, sample.hands, strict=True):
            task.target = target
        self._com.target = sample.com
        return self._ik.step(sample.q, DT)[6:]

    def velocity(self, sample: Sample) -> np.ndarray:
        """Return the velocity (nv,), base included."""
        self.step(sample)
        return self._ik.step(sample.q, DT)


class Pink:
    """`pink.solve_ik`."""

    label = "pink"

    def __init__(self, robot: wbc.Robot, hands: Sequence[str]) -> None:
        import pink
        from pink.tasks import ComTask, FrameTask, PostureTask

        self._solve, model = pink.solve_ik, robot.model
        self._configuration = pink.Configuration(model, model.createData(), robot.q_nominal.copy())
        self._feet = [FrameTask(foot, position_cost=1.0, orientation_cost=1.0) for foot in FEET]
        self._com = ComTask(cost=np.sqrt(COM))
        cost = np.sqrt(HAND)
        self._hands = [FrameTask(h, position_cost=cost, orientation_cost=cost) for h in hands]
        posture = PostureTask(cost=np.sqrt(POSTURE))
        posture.set_target(robot.q_nominal.copy())
        self._tasks = [self._com, *self._hands, posture]

    def step(self, sample: Sample) -> np.ndarray:
        """Return the joint velocities (na,)."""
        self._configuration.update(sample.q)
        for task, target in zip(self._feet, sample.feet, strict=True):
            task.set_target(target)
        for task, target in zip(self._hands, sample.hands, strict=True):
            task.set_target(target)
        self._com.set_target(sample.com)
        return self._solve(
            self._configuration,
            self._tasks,
            DT,
            solver="daqp",
            damping=1e-9 * DT**2,
            constraints=self._feet,
            safety_break=False,
        )[6:]


class Mink:
    """`mink.solve_ik`, on the MuJoCo model of the same robot."""

    label = "mink"

    def __init__(self, robot: wbc.Robot, hands: Sequence[str]) -> None:
        import mink

        from wbc.sim.model import build_model

        self._mink, model = mink, build_model(robot)
        self._configuration = mink.Configuration(model)
        self._order = [model.joint(name).qposadr[0] for name in robot.joint_names]
        self._dofs = [model.joint(name).dofadr[0] for name in robot.joint_names]
        self._feet = [mink.FrameTask(f, "site", position_cost=1, orientation_cost=1) for f in FEET]
        self._com = mink.ComTask(cost=np.sqrt(COM))
        cost = np.sqrt(HAND)
        self._hands = [
            mink.FrameTask(hand, "body", position_cost=cost, orientation_cost=cost)
            for hand in hands
        ]
        posture = mink.PostureTask(model, cost=np.sqrt(POSTURE))
        posture.set_target(self._q(robot.q_nominal))
        self._tasks = [self._com, *self._hands, posture]
        speeds = dict(zip(robot.joint_names, map(float, robot.v_max), strict=True))
        self._limits = [
            mink.ConfigurationLimit(model, gain=1.0),
            mink.VelocityLimit(model, speeds),
        ]

    def _q(self, q: np.ndarray) -> np.ndarray:
        out = np.empty(q.size)
        out[:3], out[3], out[4:7] = q[:3], q[6], q[3:6]
        out[self._order] = q[7:]
        return out

    def step(self, sample: Sample) -> np.ndarray:
        """Return the joint velocities (na,)."""
        mink = self._mink
        self._configuration.update(self._q(sample.q))
        for tasks, targets in ((self._feet, sample.feet), (self._hands, sample.hands)):
            for task, target in zip(tasks, targets, strict=True):
                task.set_target(mink.SE3.from_matrix(target.homogeneous))
        self._com.set_target(sample.com)
        v = mink.solve_ik(
            self._configuration,
            self._tasks,
            DT,
            solver="daqp",
            damping=1e-9 * DT**2,
            limits=self._limits,
            constraints=self._feet,
        )
        return v[self._dofs]


class Placo:
    """`placo.KinematicsSolver`."""

    label = "placo"

    def __init__(self, robot: wbc.Robot, hands: Sequence[str]) -> None:
        import placo

        names = {name: robot.frame_id(name) for name in FEET}
        names |= {f"{name}_frame": robot.frame_id(name) for name in hands}
        with tempfile.TemporaryDirectory() as folder:
            flags = placo.Flags.ignore_collisions
            self._robot = placo.RobotWrapper(folder, flags, urdf_text(robot.model, names))
        assert list(self._robot.joint_names()) == list(robot.joint_names)
        for k, joint in enumerate(robot.joint_names):
            self._robot.set_velocity_limit(joint, min(float(robot.v_max[k]), 1e3))
            self._robot.set_joint_limits(joint, float(robot.q_min[k]), float(robot.q_max[k]))
        self._robot.state.q = robot.q_nominal
        self._robot.update_kinematics()
        self._solver = solver = placo.KinematicsSolver(self._robot)
        solver.dt = DT
        solver.enable_velocity_limits(True)
        solver.enable_joint_limits(True)
        self._feet = []
        for foot in FEET:
            self._feet.append(solver.add_frame_task(foot, np.eye(4)))
            self._feet[-1].configure(foot, "hard", 1.0, 1.0)
        self._com = solver.add_com_task(np.zeros(3))
        self._com.configure("com", "soft", COM)
        self._hands = []
        for hand in hands:
            self._hands.append(solver.add_frame_task(f"{hand}_frame", np.eye(4)))
            self._hands[-1].configure(hand, "soft", HAND, HAND)
        posture = solver.add_joints_task()
        values = map(float, robot.q_nominal[7:])
        posture.set_joints(dict(zip(robot.joint_names, values, strict=True)))
        posture.configure("posture", "soft", POSTURE)

    def step(self, sample: Sample) -> np.ndarray:
        """Return the joint velocities (na,)."""
        self._robot.state.q = sample.q
        self._robot.update_kinematics()
        for task, target in zip(self._feet, sample.feet, strict=True):
            task.T_world_frame = target.homogeneous
        for task, target in zip(self._hands, sample.hands, strict=True):
            task.T_world_frame = target.homogeneous
        self._com.target_world = sample.com
        return np.asarray(self._solver.solve(False))[6:] / DT


@dataclass(frozen=True)
class StepResult:
    """Times of one library.

    Attributes:
        library: its name.
        median: median CPU time of a step, µs.
        p95: 95th percentile, µs.
        off: largest difference to our joint velocities, relative to the largest of ours.
    """

    library: str
    median: float
    p95: float
    off: float


def time_steps(count: int, passes: int) -> list[StepResult]:
    """Return the times of all libraries that are installed."""
    robot = wbc.load("talos")
    hands = ("arm_left_7_joint", "arm_right_7_joint")
    libraries = []
    for kind in (Wbc, Placo, Pink, Mink):
        try:
            libraries.append(kind(robot, hands))
        except ImportError as error:
            print(f"{kind.label} is left out: {error}", file=sys.stderr)
    tasks = samples(robot, hands, count)
    times = np.full((len(libraries), passes, count), np.inf)
    velocities = np.zeros((len(libraries), count, robot.na))
    for turn in range(-1, passes):
        for k, library in enumerate(libraries):
            for i, sample in enumerate(tasks):
                begun = time.process_time_ns()
                v = library.step(sample)
                if turn >= 0:
                    times[k, turn, i] = 1e-3 * (time.process_time_ns() - begun)
                velocities[k, i] = v
    best = times.min(axis=1)  # of the same step in all passes, which leaves out interruptions
    off = np.abs(velocities - velocities[0]).max(axis=(1, 2)) / np.abs(velocities[0]).max()
    return [
        StepResult(
            library.label,
            float(np.median(best[k])),
            float(np.quantile(best[k], 0.95)),
            float(off[k]),
        )
        for k, library in enumerate(libraries)
    ]


@dataclass(frozen=True)
class ReachResult:
    """Searches for random poses of one chain.

    Attributes:
        chain: the robot.
        joints: joints of the chain.
        samples: number of poses.
        solved: share that was reached, %.
        mean, median, p99: CPU time of a search, ms.
        attempts: mean number of starts.
    """

    chain: str
    joints: int
    samples: int
    solved: float
    mean: float
    median: float
    p99: float
    attempts: float


def chain_of(name: str) -> tuple[RobotModel, Sequence[str], str]:
    """Return robot, joints and frame of an arm."""
    if name == "panda":
        robot = wbc.load_fixed_base("panda")
        return robot, robot.joint_names[:7], "panda_hand"
    if name == "ur5":
        robot = wbc.load_fixed_base("ur5_robot")
        return robot, robot.joint_names, "tool0"
    walking = wbc.load(name)
    arm = UpperBody.of(walking).arm("left")
    return walking, [walking.joint_names[j] for j in arm.joints], arm.hand


def reach(name: str, count: int, start: str) -> ReachResult:
    """Return how many random poses of a chain are reached, and in what time."""
    robot, joints, frame = chain_of(name)
    index = np.array([robot.joint_index(joint) for joint in joints])
    low, high = robot.q_min[index], robot.q_max[index]
    ik = wbc.InverseKinematics(
        robot, joints=joints, limits=[wbc.JointPositionLimit(robot, margin=0.0)]
    )
    hand = ik.add(wbc.FrameTask(frame, weight=1.0))
    middle = robot.q_nominal.copy()
    middle[7 + index] = 0.5 * (low + high)
    ik.reach(middle)
    random, data = np.random.default_rng(0), robot.model.createData()
    times, solved, attempts = np.zeros(count), 0, 0
    for k in range(count):
        q = middle.copy()
        q[7 + index] = random.uniform(low, high)
        pin.forwardKinematics(robot.model, data, q)
        hand.target = pin.updateFramePlacement(robot.model, data, robot.frame_id(frame)).copy()
        at = middle.copy()
        if start == "random":
            at[7 + index] = random.uniform(low, high)
        begun = time.process_time()
        found = ik.reach(at, tolerance=TOLERANCE, seed=k)
        times[k] = 1e3 * (time.process_time() - begun)
        solved += found.reached
        attempts += found.attempts
    return ReachResult(
        name,
        len(joints),
        count,
        100.0 * solved / count,
        float(times.mean()),
        float(np.median(times)),
        float(np.quantile(times, 0.99)),
        attempts / count,
    )


@dataclass(frozen=True)
class RandomArmsResult:
    """Searches with random arms.

    Attributes:
        solver: who searched.
        samples: number of arms.
        solved: share of the poses that was reached, %.
        mean: CPU time of a search, ms.
    """

    solver: str
    samples: int
    solved: float
    mean: float


def reach_of_wbc(restarts: int) -> Callable[[RobotModel, np.ndarray, pin.SE3], bool]:
    """Return a search by `reach` with so many restarts."""

    def search(robot: RobotModel, q: np.ndarray, target: pin.SE3) -> bool:
        ik = wbc.InverseKinematics(robot, limits=[wbc.JointPositionLimit(robot, margin=0.0)])
        ik.add(wbc.FrameTask(ARMS_HAND, target, weight=1.0))
        return ik.reach(q, tolerance=TOLERANCE, restarts=restarts).reached

    return search


def steps_of_pink(robot: RobotModel, q: np.ndarray, target: pin.SE3) -> bool:
    """Return whether pink's steps reach a pose."""
    import pink

    task = pink.tasks.FrameTask(ARMS_HAND, position_cost=1.0, orientation_cost=1.0)
    task.set_target(target)
    model = pin.buildReducedModel(robot.model, [1], q)  # without the base's joint
    configuration = pink.Configuration(model, model.createData(), q[7:])
    for _ in range(PINK_STEPS):
        if np.abs(task.compute_error(configuration)).max() <= TOLERANCE:
            return True
        try:
            v = pink.solve_ik(configuration, [task], PINK_DT, solver="daqp", safety_break=False)
        except pink.exceptions.NoSolutionFound:
            return False
        configuration.integrate_inplace(v, PINK_DT)
    return False


def random_arms(count: int) -> list[RandomArmsResult]:
    """Return how many random poses of random arms are reached, and in what time."""
    searches = {"wbc": reach_of_wbc(100), "wbc, one start": reach_of_wbc(0)}
    try:
        import pink  # noqa: F401

        searches["pink, one start"] = steps_of_pink
    except ImportError as error:
        print(f"pink is left out: {error}", file=sys.stderr)
    solved = dict.fromkeys(searches, 0)
    times = dict.fromkeys(searches, 0.0)
    random = np.random.default_rng(0)
    for _ in range(count):
        robot = random_arm(random)
        data = robot.model.createData()
        goal, start = robot.q_nominal.copy(), robot.q_nominal.copy()
        goal[7:] = random.uniform(robot.q_min, robot.q_max)
        start[7:] = random.uniform(robot.q_min, robot.q_max)
        pin.forwardKinematics(robot.model, data, goal)
        frame = robot.frame_id(ARMS_HAND)
        target = pin.updateFramePlacement(robot.model, data, frame).copy()
        for name, search in searches.items():
            begun = time.process_time()
            solved[name] += search(robot, start, target)
            times[name] += time.process_time() - begun
    return [
        RandomArmsResult(name, count, 100.0 * solved[name] / count, 1e3 * times[name] / count)
        for name in searches
    ]


def main() -> int:
    """Run one of the comparisons, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("step", "reach", "random"))
    parser.add_argument("--samples", type=int, default=200, help="samples (default: %(default)s)")
    parser.add_argument("--passes", type=int, default=7, help="of each step (default: %(default)s)")
    parser.add_argument("--chain", action="append", choices=CHAINS, help="default: all")
    parser.add_argument(
        "--start", choices=("middle", "random"), default="middle", help="of `reach`"
    )
    parser.add_argument("--json", type=Path, help="write the figures here")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    rows: list[object]
    if args.what == "step":
        steps = time_steps(args.samples, args.passes)
        print("| library | median, µs | p95, µs | wbc is | off |")
        print("| --- | --- | --- | --- | --- |")
        for row in steps:
            share = f"{steps[0].median / row.median:.2f} ×"
            print(f"| {row.library} | {row.median:.0f} | {row.p95:.0f} | {share} | {row.off:.0e} |")
        rows = [*steps]
    elif args.what == "random":
        print("| solver | samples | solved | mean, ms |\n| --- | --- | --- | --- |")
        arms = random_arms(args.samples)
        for one in arms:
            print(f"| {one.solver} | {one.samples} | {one.solved:.1f} % | {one.mean:.1f} |")
        rows = [*arms]
    else:
        print("| arm of | joints | solved | mean, ms | median, ms | p99, ms | attempts |")
        print("| --- | --- | --- | --- | --- | --- | --- |")
        run: Callable[[str], ReachResult] = lambda name: reach(name, args.samples, args.start)  # noqa: E731
        rows = []
        for name in args.chain or CHAINS:
            found = run(name)
            rows.append(found)
            print(
                f"| {name} | {found.joints} | {found.solved:.2f} % | {found.mean:.2f} | "
                f"{found.median:.2f} | {found.p99:.2f} | {found.attempts:.2f} |",
                flush=True,
            )
        print(f"\n{args.samples} samples each; published: {PUBLISHED}")
    if args.json:
        args.json.write_text(json.dumps([asdict(r) for r in rows], indent=1) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
