"""Whether two libraries solve the same problem: how far their answers to it are apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import wbc
from peers.case import SOLES, STANCES, Case
from wbc.limits import JointPositionLimit, JointVelocityLimit

Answers = Mapping[str, np.ndarray]  # the fields of `Outcome`, stacked


@dataclass(frozen=True)
class Spread:
    """Median and largest over the ticks of the largest difference in each."""

    median: float
    max: float


@dataclass(frozen=True)
class Agreement:
    """A peer's answers less ours.

    Attributes:
        unsolved: ticks that the peer gives no solution for.
        com: of the CoM's acceleration, m/s².
        acceleration: of v̇, m/s² and rad/s².
        torque: N·m.
        wrench: of the feet's wrenches, N and N·m.
        largest_acceleration: what the differences compare with, and so on.
    """

    unsolved: int
    com: Spread
    acceleration: Spread
    torque: Spread
    wrench: Spread
    largest_acceleration: float
    largest_torque: float


def agreement(case: Case, ours: Answers, theirs: Answers) -> Agreement:
    """How far a peer's answers are from ours, on the ticks that both solve."""
    both = ours["ok"] & theirs["ok"]
    if not both.any():
        raise ValueError(f"{case.name}: no tick that both solve")
    robot = wbc.load(case.robot)
    ticks = case.ticks
    kin = wbc.Kinematics(robot, robot.standing())
    d_acceleration = (theirs["acceleration"] - ours["acceleration"])[both]
    com = []
    for k, d in zip(np.flatnonzero(both), d_acceleration, strict=True):
        kin.update(wbc.State(ticks.q[k], ticks.v[k]))
        com.append(kin.J_com @ d)

    def spread(difference: np.ndarray) -> Spread:
        worst = np.abs(difference).reshape(len(difference), -1).max(axis=1)
        return Spread(float(np.median(worst)), float(worst.max()))

    return Agreement(
        unsolved=int((~theirs["ok"]).sum()),
        com=spread(np.array(com)),
        acceleration=spread(d_acceleration),
        torque=spread((theirs["tau"] - ours["tau"])[both]),
        wrench=spread((theirs["wrenches"] - ours["wrenches"])[both]),
        largest_acceleration=float(np.abs(ours["acceleration"]).max()),
        largest_torque=float(np.abs(ours["tau"]).max()),
    )


def active_rows(case: Case, ours: Answers) -> np.ndarray:
    """(n,) independent inequalities that hold with equality in our answers.

    Joints at their torque limit, joints at an acceleration bound of the position and velocity
    limits, and of each foot's wrench cone the rank of the rows that bind.
    """
    robot = wbc.load(case.robot)
    limits = case.limits
    how = {"braking": limits.braking, "horizon": limits.horizon}
    bounds = (
        JointPositionLimit(robot, margin=0.0, **how),
        JointVelocityLimit(robot, limits.velocity, **how),
    )
    cones = [
        wbc.SurfaceContact(
            SOLES[side],
            case.half_length,
            case.half_width,
            friction=case.friction * np.sqrt(2.0),
        ).cone
        for side in ("left", "right")
    ]
    kin = wbc.Kinematics(robot, robot.standing())
    count = (np.abs(ours["tau"]) > limits.torque * (1.0 - 1e-6)).sum(axis=1)
    for k in range(len(case.ticks)):
        kin.update(wbc.State(case.ticks.q[k], case.ticks.v[k]))
        joints = ours["acceleration"][k, 6:]
        for bound in bounds:
            low, high = bound.bounds(kin)
            count[k] += int(((joints < low + 1e-5) | (joints > high - 1e-5)).sum())
        for index, side in enumerate(("left", "right")):
            if side in STANCES[int(case.ticks.stance[k])]:
                cone = cones[index]
                binding = cone[cone @ ours["wrenches"][k, index] > -1e-3]
                if len(binding):
                    count[k] += int(np.linalg.matrix_rank(binding))
    return count
