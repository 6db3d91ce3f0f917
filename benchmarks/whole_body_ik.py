"""Postures of a whole body: reaching in balance, and with both arms without self-collision.

`balance`: the target is the pose of the left hand in a posture that stands: joints of arm and waist
random within their ranges, the pelvis moved at random by up to 10 cm and 0.3 rad, both feet
brought back to the ground, centre of mass above the soles (less a fifth), no bodies in contact.
`reach` starts from the nominal posture and moves all joints; feet and hand must be reached
to 1e-5 m and rad, with the centre of mass above the same polygon.

`collision`: the targets are the positions of both hands in a posture in which no bodies of the
robot are nearer than 1 cm, arms random within their ranges. `reach` searches from the nominal
posture; then both hands and the arms go to what it found, step by step (`step`, 10 ms), from where
they are: the path is not planned, bodies that meet stop, and after such a pair the next path begins
in the nominal posture. "least" is the least distance of any two
bodies along all paths, "pairs" the CPU time that the limit takes in a step.

    python benchmarks/whole_body_ik.py balance --samples 1000
    python benchmarks/whole_body_ik.py collision --samples 1000
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import sys
import time
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

import wbc
from wbc.limits import BarrierRows, ComPolygonLimit, SelfCollisionLimit
from wbc.robot.self_collision import SelfCollision
from wbc.robot.upper_body import UpperBody

ROBOTS = ("talos", "g1")
TOLERANCE = 1e-5  # m, rad
DT, STEPS = 0.01, 300  # s, of a path
CLEARANCE = 0.01  # m, of the postures that give the targets
ARRIVED = 5e-3  # m


@dataclass(frozen=True)
class BalanceResult:
    """Searches for postures in balance.

    Attributes:
        robot: its name.
        samples: number of targets.
        solved: share that was reached, %.
        mean, p99: CPU time of a search, ms.
    """

    robot: str
    samples: int
    solved: float
    mean: float
    p99: float


@dataclass(frozen=True)
class CollisionResult:
    """Reaching with both arms.

    Attributes:
        robot: its name.
        samples: number of pairs of targets.
        solved: share for which the search found a posture without collisions, %.
        arrived: share that the hands arrived at, to 5 mm, without a planned path, %.
        least: least distance of two bodies along all paths, mm.
        mean: CPU time of a search, ms.
        pairs: median CPU time of the limit in a step, µs.
        step: median CPU time of a step, µs.
    """

    robot: str
    samples: int
    solved: float
    arrived: float
    least: float
    mean: float
    pairs: float
    step: float


def sole_corners(robot: wbc.Robot, share: float) -> np.ndarray:
    """Return the corners of a share of both soles in the nominal posture, (8, 2) m."""
    kin = wbc.Kinematics(robot, robot.standing())
    corners = [
        kin.frame(sole.name).act(share * np.array([x * sole.half_length, y * sole.half_width, 0.0]))
        for sole in robot.soles
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    return np.array(corners)[:, :2]


def run_balance(name: str, count: int) -> BalanceResult:
    """Return how many poses of a hand are reached in balance."""
    robot = wbc.load(name)
    body, bodies = UpperBody.of(robot), SelfCollision.of(robot)
    arm = body.arm("left")
    index = np.array([*arm.joints, *body.waist])
    polygon = ComPolygonLimit(sole_corners(robot, 0.8))
    feet_ik = wbc.InverseKinematics(
        robot, joints=[robot.joint_names[j - 6] for leg in robot.legs for j in leg]
    )
    ik = wbc.InverseKinematics(robot)
    ik.set_limits([*ik.limits, polygon])
    nominal = wbc.Kinematics(robot, robot.standing())
    for one in (feet_ik, ik):
        for sole in robot.soles:
            one.add(wbc.FrameTask(sole.name, nominal.frame(sole.name).copy(), weight=1.0))
    hand = ik.add(wbc.FrameTask(arm.hand, weight=1.0))
    random, times, solved = np.random.default_rng(0), [], 0
    room = ik.limits[0]
    assert isinstance(room, wbc.JointPositionLimit)
    while len(times) < count:
        shift = np.zeros(robot.nv)
        shift[:3], shift[3:6] = random.uniform(-0.1, 0.1, 3), random.uniform(-0.3, 0.3, 3)
        q = pin.integrate(robot.model, robot.q_nominal, shift)
        q[7 + index] = random.uniform(room.lower[index], room.upper[index])
        stance = feet_ik.reach(q, restarts=2)
        kin = wbc.Kinematics(robot, wbc.State(stance.q, np.zeros(robot.nv)))
        rows = BarrierRows(
            np.full(polygon.size, np.inf),
            np.zeros((polygon.size, robot.nv)),
            np.zeros(polygon.size),
        )
        polygon.write_barrier(kin, rows)
        if not stance.reached or rows.h.min() < 0.0 or bodies.first_contact(stance.q):
            continue
        hand.target = kin.frame(arm.hand).copy()
        begun = time.process_time()
        found = ik.reach(robot.q_nominal, tolerance=TOLERANCE, seed=len(times))
        times.append(1e3 * (time.process_time() - begun))
        solved += found.reached
    return BalanceResult(
        name,
        count,
        100.0 * solved / count,
        float(np.mean(times)),
        float(np.quantile(times, 0.99)),
    )


def run_collision(name: str, count: int) -> CollisionResult:
    """Return how many pairs of positions both hands reach, and how near bodies come."""
    robot = wbc.load(name)
    arms = UpperBody.of(robot).both_arms()
    bodies = SelfCollision.of(robot)
    joints = [robot.joint_names[j] for arm in arms for j in arm.joints]
    index = np.array([robot.joint_index(joint) for joint in joints])
    limit = SelfCollisionLimit(robot)
    position = wbc.JointPositionLimit(robot)
    ik = wbc.InverseKinematics(
        robot, joints=joints, limits=[position, wbc.JointVelocityLimit(robot), limit]
    )
    hands = [ik.add(wbc.PositionTask(arm.hand)) for arm in arms]
    posture = ik.add(wbc.PostureTask(robot, joints=joints, weight=1.0))
    random, times, steps, pairs = np.random.default_rng(0), [], [], []
    solved = arrived = 0
    least, now = np.inf, robot.q_nominal.copy()
    barrier = BarrierRows(
        np.full(limit.size, np.inf), np.zeros((limit.size, robot.nv)), np.zeros(limit.size)
    )
    while len(times) < count:
        q = robot.q_nominal.copy()
        q[7 + index] = random.uniform(position.lower[index], position.upper[index])
        if bodies.first_contact(q, CLEARANCE):
            continue
        kin = wbc.Kinematics(robot, wbc.State(q, np.zeros(robot.nv)))
        for hand in hands:
            hand.target = kin.frame(hand.frame).translation.copy()
        begun = time.process_time()
        found = ik.reach(robot.q_nominal, targets=hands, seed=len(times), restarts=20)
        times.append(1e3 * (time.process_time() - begun))
        solved += found.reached
        if not found.reached:
            continue
        posture.target = found.q[7 + index]
        for k in range(STEPS):
            begun = time.process_time()
            v = ik.step(now, DT)
            if k % 20 == 0:
                steps.append(1e6 * (time.process_time() - begun))
                assert ik.kinematics is not None
                begun = time.process_time()
                limit.write_barrier(ik.kinematics, barrier)
                pairs.append(1e6 * (time.process_time() - begun))
            now = pin.integrate(robot.model, now, DT * v)
            least = min(least, min(limit.distances.values(), default=np.inf))
            if np.abs(v).max() < 1e-3:
                break
        at = wbc.Kinematics(robot, wbc.State(now, np.zeros(robot.nv)))
        off = max(np.linalg.norm(at.frame(h.frame).translation - h.target) for h in hands)
        if off < ARRIVED:
            arrived += 1
        else:  # arms that are entangled would stay so
            now = robot.q_nominal.copy()
    return CollisionResult(
        name,
        count,
        100.0 * solved / count,
        100.0 * arrived / count,
        1e3 * float(least),
        float(np.mean(times)),
        float(np.median(pairs)),
        float(np.median(steps)),
    )


def main() -> int:
    """Run one of the measurements, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("balance", "collision"))
    parser.add_argument("--samples", type=int, default=100, help="samples (default: %(default)s)")
    parser.add_argument("--robot", action="append", choices=ROBOTS, help="default: all")
    parser.add_argument("--json", type=Path, help="write the figures here")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    rows: list[object] = []
    if args.what == "balance":
        print("| robot | samples | solved | mean, ms | p99, ms |\n| --- | --- | --- | --- | --- |")
        for name in args.robot or ROBOTS:
            row = run_balance(name, args.samples)
            rows.append(row)
            print(
                f"| {name} | {row.samples} | {row.solved:.1f} % | {row.mean:.1f} | {row.p99:.0f} |",
                flush=True,
            )
    else:
        print(
            "| robot | samples | solved | arrived | least, mm | search, ms | pairs, µs | step, µs |"
        )
        print("| --- | --- | --- | --- | --- | --- | --- | --- |")
        for name in args.robot or ROBOTS:
            one = run_collision(name, args.samples)
            rows.append(one)
            print(
                f"| {name} | {one.samples} | {one.solved:.1f} % | {one.arrived:.1f} % | "
                f"{one.least:.1f} | {one.mean:.1f} | {one.pairs:.0f} | {one.step:.0f} |",
                flush=True,
            )
    if args.json:
        args.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
