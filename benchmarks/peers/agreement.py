"""Checks that two libraries solve the same problem: differences of their solutions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import wbc
from peers.case import SOLES, STANCES, Case
from wbc.limits import JointPositionLimit, JointVelocityLimit

Solutions = Mapping[str, np.ndarray]  # the fields of `Outcome`, stacked


@dataclass(frozen=True)
class Spread:
    """Median and maximum over the ticks of the largest difference in each tick."""

    median: float
    max: float


@dataclass(frozen=True)
class Agreement:
    """Differences between a peer's solutions and ours.

    Attributes:
        unsolved: ticks without a solution of the peer.
        com: difference of the CoM's acceleration, m/s².
        acceleration: difference of v̇, m/s² and rad/s².
        torque: difference of the torques, N·m.
        wrench: difference of the feet's wrenches, N and N·m.
        largest_acceleration: largest |v̇| of our solutions, m/s² and rad/s².
        largest_torque: largest torque of our solutions, N·m.
    """

    unsolved: int
    com: Spread
    acceleration: Spread
    torque: Spread
    wrench: Spread
    largest_acceleration: float
    largest_torque: float


def agreement(case: Case, ours: Solutions, theirs: Solutions) -> Agreement:
    """Return the differences of a peer's solutions from ours, on the ticks that both solve."""
    both = ours["ok"] & theirs["ok"]
    if not both.any():
        raise ValueError(f"{case.name}: no tick is solved by both")
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


def active_rows(case: Case, ours: Solutions) -> np.ndarray:
    """Return the number of independent active inequalities of our solutions, (n,).

    They are joints at their torque limit, joints at an acceleration bound of the position and
    velocity limits, and the rank of the active rows of each foot's wrench cone.
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
