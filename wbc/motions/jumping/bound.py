"""The fastest take-off that a robot's limits allow, and the limit that sets it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wbc.motions.jumping.path import JumpPath
from wbc.robot import Robot

_BISECTIONS = 40  # of the interval that contains the best pace
_RELAXATION = 1.1  # factor on a joint's limit, to see whether the limit is active


@dataclass(frozen=True, slots=True)
class TakeOffBound:
    """The fastest take-off of all push-offs along a robot's jump paths.

    Attributes:
        speed: greatest speed of the CoM when the soles leave the ground, m/s; 0 for a robot
            that cannot even rise.
        rise: greatest rise of the CoM after that, v²/2g, m.
        take_off: height of the CoM at which it is reached, m above the soles.
        crouch: height of the CoM from which it is reached, m.
        joint: the joint whose limit, raised by a tenth, raises the speed most; one of a pair.
        quantity: kind of the limit, "torque" or "velocity".
    """

    speed: float
    rise: float
    take_off: float
    crouch: float
    joint: str
    quantity: str

    def __str__(self) -> str:
        if self.speed == 0.0:
            return f"it cannot rise from any crouch for the {self.quantity} of '{self.joint}'"
        return (
            f"its CoM takes off with {self.speed:.2f} m/s at most and rises by "
            f"{1e3 * self.rise:.0f} mm at most, for the {self.quantity} of '{self.joint}'"
        )


def take_off_bound(robot: Robot, paths: Sequence[JumpPath]) -> TakeOffBound:
    """Return the bound over all crouches, take-off heights and paces.

    Along a path the torques are linear in (z̈, ż²), and so in β = ż² at neighbouring heights:
    dβ/dz = 2 z̈. From rest in the crouch, the largest β that any pace reaches follows from
    height to height, β₊ = max {β + 2 Δz z̈ : |τ(z̈, β)| ≤ τ_max, |q' √β| ≤ q̇_max}: what is
    reachable at a height is an interval that begins at 0, and its upper end depends only on
    the upper end before (Pham and Pham, A new approach to time-optimal path
    parameterization based on reachability analysis, T-RO 2018). So it is a bound, to the
    resolution of the path's grid, for all paces and crouches of these paths: soles flat until
    take-off, no spin. Torque ramps, the flight and the landing, which a plan has to respect
    too, only reduce it.

    Args:
        robot: the robot.
        paths: paths with different take-off heights, their tops.
    """
    found = [(*_top_speed(path, 0, robot.tau_max, robot.v_max), path) for path in paths]
    best, start, path = max(found, key=lambda each: each[0])
    if best == 0.0:
        return TakeOffBound(0.0, 0.0, paths[0].top, paths[0].top, _weakest(robot, paths), "torque")
    joint, quantity = _limiting(robot, path, start, best)
    return TakeOffBound(
        best,
        best**2 / (2.0 * robot.gravity),
        path.top,
        float(path.height[start]),
        joint,
        quantity,
    )


def _top_speed(
    path: JumpPath, first: int, tau_max: np.ndarray, v_max: np.ndarray
) -> tuple[float, int]:
    """Return the largest ż at the path's top, m/s, from rest at one of its heights, and which.

    A robot that comes from farther below is not slower at any height, so the lowest height from
    which it does not get stuck is the best one.

    Args:
        path: the configurations.
        first: lowest height that counts.
        tau_max, v_max: (na,) limits.
    """
    fastest = np.min((v_max / np.maximum(np.abs(path.tangent[:, 6:]), 1e-9)) ** 2, axis=1)
    beta, start = 0.0, first
    for k in range(first, len(path.height) - 1):
        step = 2.0 * (path.height[k + 1] - path.height[k])
        beta = min(_next(path.stance[k], tau_max, beta, step), float(fastest[k + 1]))
        if beta <= 0.0:
            beta, start = 0.0, k + 1
    return float(np.sqrt(beta)), start


def _next(torque: np.ndarray, tau_max: np.ndarray, bound: float, step: float) -> float:
    """Return max {β + step z̈ : |a z̈ + b β + c| ≤ τ_max, 0 ≤ β ≤ bound}; concave in β.

    Args:
        torque: (na, 3) columns a, b, c.
        tau_max: (na,) torque limits, N·m.
        bound: upper end of β before the step, m²/s².
        step: 2 Δz, m.
    """
    a, b, c = torque[np.abs(torque[:, 0]) > 1e-9].T
    limit = tau_max[np.abs(torque[:, 0]) > 1e-9] / np.abs(a)

    def reached(beta: float) -> tuple[float, float]:
        """Return the value and its slope."""
        lift = limit - (b * beta + c) / a
        k = int(np.argmin(lift))
        return beta + step * float(lift[k]), 1.0 - step * float(b[k] / a[k])

    value, slope = reached(bound)
    if slope >= 0.0:
        return value
    low, high = 0.0, bound
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        value, slope = reached(middle)
        low, high = (middle, high) if slope > 0.0 else (low, middle)
    return value


def _weakest(robot: Robot, paths: Sequence[JumpPath]) -> str:
    """Return the joint that is overloaded most where standing still takes least."""
    shares = np.abs(np.vstack([path.stance[..., 2] for path in paths])) / robot.tau_max
    return robot.joint_names[int(np.argmax(shares[int(np.argmin(shares.max(axis=1)))]))]


def _limiting(robot: Robot, path: JumpPath, start: int, speed: float) -> tuple[str, str]:
    best, found = -np.inf, (0, "torque")
    pairs = [tuple(i - 6 for i in pair) for pair in zip(*robot.legs, strict=False)]
    for pair in pairs:
        more = np.ones(robot.na)
        more[list(pair)] = _RELAXATION
        gains = (
            _top_speed(path, start, robot.tau_max * more, robot.v_max)[0] - speed,
            _top_speed(path, start, robot.tau_max, robot.v_max * more)[0] - speed,
        )
        for gain, quantity in zip(gains, ("torque", "velocity"), strict=True):
            if gain > best:
                best, found = gain, (pair[0], quantity)
    return robot.joint_names[found[0]], found[1]
