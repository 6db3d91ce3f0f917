"""A vertical jump within a robot's torque, velocity and position limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from wbc.errors import MotionError
from wbc.motions.jumping.bound import TakeOffBound, take_off_bound
from wbc.motions.jumping.path import JumpPath
from wbc.motions.jumping.path_search import find_path
from wbc.motions.jumping.profile import HeightProfile, HopProfile, stroke
from wbc.robot import Robot

_SAMPLES = np.linspace(0.0, 1.0, 31)
_TAKE_OFFS = np.linspace(0.68, 1.04, 13)  # shares of the standing height
_DEPTHS = np.linspace(0.04, 0.20, 7)  # of the push-off, likewise
_RISES = np.linspace(0.4, 1.0, 7)  # shares of the clearance that come from the CoM's rise
_PATH_LENGTH = 0.35  # of the standing height
_MIN_PUSH_OFF = 0.4  # duration in units of √(height / g): motors need time for their ramps
_TOUCHDOWN = 0.1  # m/s, downward velocity of the soles
#: Weights of the motion of waist and arms, see `find_path`: tried one after the other.
ARM_WEIGHTS = (2e-5, 5e-6, 1e-6)
_MIN_CLEARANCE = 0.003  # m
_MAX_EFFORT = 0.95  # share of a limit that a plan may use: the rest is for feedback
_BISECTIONS = 5  # of the interval that contains the highest jump


class JumpTooHigh(MotionError):
    """A jump is beyond a robot's limits; the message says which, and what bounds it.

    Attributes:
        bound: the bound on the robot's take-off.
    """

    def __init__(self, text: str, bound: TakeOffBound) -> None:
        super().__init__(text)
        self.bound = bound


@dataclass(frozen=True)
class JumpPlan:
    """A jump on the spot.

    Attributes:
        path: the configurations; the soles leave the ground, and touch it again, with the CoM at
            the path's top.
        lowest: height of the CoM in the crouch, m above the soles.
        speed: speed of the CoM at take-off, m/s.
        push_off: height of the CoM above the soles over time.
        flight: height of the soles over time.
        landing: height of the CoM above the soles over time, from touchdown on.
        torque_share: largest |τ|/τ_max of push-off, flight and landing.
        torque_joint: name of the joint that has it.
        speed_share: largest |q̇|/q̇_max.
        speed_joint: name of the joint that has it.
    """

    path: JumpPath
    lowest: float
    speed: float
    push_off: HeightProfile
    flight: HopProfile
    landing: HeightProfile
    torque_share: float
    torque_joint: str
    speed_share: float
    speed_joint: str

    def __repr__(self) -> str:
        return (
            f"JumpPlan({self.path.robot.name}, {1e3 * self.clearance:.0f} mm clear, take-off at "
            f"{self.speed:.2f} m/s, {100.0 * self.torque_share:.0f} % of the torque of "
            f"'{self.torque_joint}')"
        )

    @property
    def take_off(self) -> float:
        """Height of the CoM above the soles at take-off, m."""
        return self.path.top

    @property
    def clearance(self) -> float:
        """Height of the soles in the middle of the flight, m."""
        return self.flight.clearance

    @property
    def rise(self) -> float:
        """Rise of the CoM after take-off, v²/2g, m."""
        return self.speed**2 / (2.0 * self.path.robot.gravity)

    @property
    def holding_effort(self) -> float:
        """The largest share of a limit of torque or velocity."""
        return max(self.torque_share, self.speed_share)

    @classmethod
    def along(cls, path: JumpPath, lowest: float, rise: float, clearance: float) -> JumpPlan:
        """Return the jump along a path.

        Args:
            path: the configurations.
            lowest: height of the CoM in the crouch, m.
            rise: rise of the CoM after take-off, m.
            clearance: height of the soles in the middle of the flight, m.
        """
        robot, g = path.robot, path.robot.gravity
        speed = float(np.sqrt(2.0 * g * rise))
        push_off = stroke(lowest, 0.0, (path.top, speed, -g))
        landing = stroke(path.top, -speed, (lowest, 0.0, 0.0), begin=-g)
        flight = HopProfile(2.0 * speed / g, clearance, _TOUCHDOWN)
        up, down = (s.sample(_SAMPLES * s.duration) for s in (push_off, landing))
        t = _SAMPLES * flight.duration
        z, rate, acceleration = flight.sample(t)
        air = (path.top + speed * t - 0.5 * g * t * t - z, speed - g * t - rate, -g - acceleration)
        torque = np.vstack(
            [
                path.torque(path.stance, *up),
                path.torque(path.stance, *down),
                path.torque(path.flight, *air),
            ]
        )
        velocity = np.vstack([path.joint_velocity(z, rate) for z, rate, _ in (up, down, air)])
        shares = [np.abs(torque) / robot.tau_max, np.abs(velocity) / robot.v_max]
        joints = [robot.joint_names[int(np.argmax(share.max(axis=0)))] for share in shares]
        most = [float(share.max()) for share in shares]
        return cls(
            path, lowest, speed, push_off, flight, landing, most[0], joints[0], most[1], joints[1]
        )


def jump_paths(robot: Robot, arm_weight: float = ARM_WEIGHTS[0]) -> list[JumpPath]:
    """Return paths with different take-off heights; none if the legs cannot raise the CoM.

    Args:
        robot: the robot.
        arm_weight: weight of the motion of waist and arms, see `find_path`.
    """
    height = robot.com_height
    traced = (
        find_path(robot, share * height, _PATH_LENGTH * height, arm_weight) for share in _TAKE_OFFS
    )
    return [path for path in traced if path is not None]


def plan_jump(robot: Robot, clearance: float) -> JumpPlan:
    """Return the jump that takes the least share of all limits.

    If none keeps the limits, waist and arms may swing more; see `ARM_WEIGHTS`.

    Args:
        robot: the robot.
        clearance: height of both soles over the ground at the apex, m.

    Raises:
        JumpTooHigh: the jump is beyond the limits even so; with the bound.
        MotionError: the clearance is not positive, or the legs cannot lower and raise the CoM.
    """
    if not 0.0 < clearance < np.inf:
        raise MotionError(f"jump: a clearance of {clearance} m must be positive and finite")
    paths: list[JumpPath] = []
    for arm_weight in ARM_WEIGHTS:
        more = jump_paths(robot, arm_weight)
        plan = _gentlest(more, clearance)
        if plan is not None and plan.holding_effort <= _MAX_EFFORT:
            return plan
        paths += more
    if not paths:
        raise MotionError(f"jump: the legs of '{robot.name}' cannot lower and raise its body")
    raise _too_high(robot, paths, clearance)


def _too_high(robot: Robot, paths: Sequence[JumpPath], clearance: float) -> JumpTooHigh:
    bound = take_off_bound(robot, paths)
    highest = 0.0
    if bound.rise > 0.0:
        highest = _highest(paths, min(clearance, bound.rise / float(_RISES[0])))
    best = _gentlest(paths, clearance)
    lines = [f"jump: {robot.name} cannot clear {1e3 * clearance:.0f} mm: {bound}"]
    if best is not None:
        share, joint, quantity = max(
            (best.torque_share, best.torque_joint, "torque"),
            (best.speed_share, best.speed_joint, "velocity"),
        )
        lines.append(
            f"this jump would take {100.0 * share:.0f} % of the {quantity} of '{joint}' (at most "
            f"{100.0 * _MAX_EFFORT:.0f} %)"
        )
    lines.append(
        f"ask for {1e3 * highest:.0f} mm or less"
        if highest > _MIN_CLEARANCE
        else f"not even {1e3 * _MIN_CLEARANCE:.0f} mm are within its limits"
    )
    return JumpTooHigh("; ".join(lines), bound)


def _gentlest(paths: Sequence[JumpPath], clearance: float) -> JumpPlan | None:
    return min(_candidates(paths, clearance), key=lambda plan: plan.holding_effort, default=None)


def _candidates(paths: Sequence[JumpPath], clearance: float) -> Iterator[JumpPlan]:
    """Yield jumps of a clearance (m) from different crouches, take-off heights and rises."""
    for path in paths:
        robot = path.robot
        shortest = _MIN_PUSH_OFF * float(np.sqrt(robot.com_height / robot.gravity))
        room = path.top - float(path.height[0])
        for depth in _DEPTHS * robot.com_height:
            for share in _RISES:
                rise = float(share * clearance)
                if max(depth, clearance - rise) > room:
                    continue
                plan = JumpPlan.along(path, float(path.top - depth), rise, clearance)
                if plan.push_off.duration >= shortest:
                    yield plan


def _highest(paths: Sequence[JumpPath], beyond: float) -> float:
    """Return the highest clearance (m) whose plan keeps the limits, by bisection; 0 for none."""
    low, high = 0.0, beyond
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if middle > _MIN_CLEARANCE and any(
            plan.holding_effort <= _MAX_EFFORT for plan in _candidates(paths, middle)
        ):
            low = middle
        else:
            high = middle
    return low
