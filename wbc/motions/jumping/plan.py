"""A vertical jump within a robot's torque, velocity and position limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from wbc.errors import MotionError
from wbc.motions.jumping.bound import TakeOffBound, take_off_bound
from wbc.motions.jumping.path import JumpPath, gravity_of
from wbc.motions.jumping.path_search import trace_path
from wbc.motions.jumping.profile import HeightProfile, HopProfile, stroke
from wbc.robot import Robot

_SAMPLES = np.linspace(0.0, 1.0, 31)
_TAKE_OFFS = np.linspace(0.68, 1.04, 13)  # shares of the standing height
_DEPTHS = np.linspace(0.04, 0.20, 7)  # of the push-off, likewise
_RISES = np.linspace(0.4, 1.0, 7)  # shares of the clearance that come from the CoM's rise
_REACH = 0.35  # of the standing height: how far down a path goes
_SHORTEST = 0.4  # of the push-off, in units of √(height / g): motors need time for their ramps
_TOUCHDOWN = 0.1  # m/s, downward speed of the soles
STILLNESS = (2e-5, 5e-6, 1e-6)  #: of waist and arms, see `trace_path`: tried one after the other
_WORTH = 0.003  # m: a clearance below is none
_MOST_EFFORT = 0.95  # share of a limit that a plan may use: the rest is for feedback
_HALVINGS = 5  # of the interval in which the highest jump is looked for


class JumpTooHigh(MotionError):
    """A jump is beyond a robot's limits; the text says which, and what bounds it.

    Attributes:
        bound: on its take-off.
    """

    def __init__(self, text: str, bound: TakeOffBound) -> None:
        super().__init__(text)
        self.bound = bound


@dataclass(frozen=True)
class JumpPlan:
    """A jump on the spot.

    Attributes:
        path: the configurations on the way; the soles leave the ground, and touch it again,
            with the CoM at its top.
        lowest: height of the CoM in the crouch, m above the soles.
        speed: of the CoM at take-off, m/s.
        push_off: height of the CoM above the soles over time.
        flight: height of the soles over time.
        landing: height of the CoM above the soles over time, from touchdown on.
        torque_share: largest |τ|/τ_max of push-off, flight and landing.
        torque_joint: of which joint.
        speed_share: largest |q̇|/q̇_max.
        speed_joint: of which joint.
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
        """How far the CoM rises after take-off, v²/2g, m."""
        return self.speed**2 / (2.0 * gravity_of(self.path.robot))

    @property
    def holding_effort(self) -> float:
        """The largest share of a limit of torque or velocity."""
        return max(self.torque_share, self.speed_share)

    @classmethod
    def along(cls, path: JumpPath, lowest: float, rise: float, clearance: float) -> JumpPlan:
        """The jump along a path, from a crouch (m), by a rise of the CoM and of the soles (m)."""
        robot, g = path.robot, gravity_of(path.robot)
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


def jump_paths(robot: Robot, stillness: float = STILLNESS[0]) -> list[JumpPath]:
    """Paths with different take-off heights; none for legs that cannot move the CoM up and down.

    Args:
        robot: the robot.
        stillness: of waist and arms, see `trace_path`.
    """
    height = robot.com_height
    traced = (trace_path(robot, share * height, _REACH * height, stillness) for share in _TAKE_OFFS)
    return [path for path in traced if path is not None]


def plan_jump(robot: Robot, clearance: float) -> JumpPlan:
    """The jump of a clearance of both soles (m) that takes the least share of all limits.

    When there is none within the limits, waist and arms may swing more, and then still more.

    Raises:
        JumpTooHigh: it is beyond the limits all the same; with the bound.
        MotionError: the clearance is not positive, or the legs cannot move the CoM up and down.
    """
    if not 0.0 < clearance < np.inf:
        raise MotionError(f"jump: a clearance of {clearance} m must be positive and finite")
    paths: list[JumpPath] = []
    for stillness in STILLNESS:
        more = jump_paths(robot, stillness)
        plan = _gentlest(more, clearance)
        if plan is not None and plan.holding_effort <= _MOST_EFFORT:
            return plan
        paths += more
    if not paths:
        raise MotionError(f"jump: the legs of '{robot.name}' cannot lower and raise its body")
    raise _too_high(robot, paths, clearance)


def _too_high(robot: Robot, paths: Sequence[JumpPath], clearance: float) -> JumpTooHigh:
    bound = take_off_bound(robot, paths)
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
            f"{100.0 * _MOST_EFFORT:.0f} %)"
        )
    lines.append(
        f"ask for {1e3 * highest:.0f} mm or less"
        if highest > _WORTH
        else f"not even {1e3 * _WORTH:.0f} mm are within its limits"
    )
    return JumpTooHigh("; ".join(lines), bound)


def _gentlest(paths: Sequence[JumpPath], clearance: float) -> JumpPlan | None:
    return min(_candidates(paths, clearance), key=lambda plan: plan.holding_effort, default=None)


def _candidates(paths: Sequence[JumpPath], clearance: float) -> Iterator[JumpPlan]:
    """Jumps of a clearance (m) from different crouches, take-off heights and rises."""
    for path in paths:
        robot = path.robot
        shortest = _SHORTEST * float(np.sqrt(robot.com_height / gravity_of(robot)))
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
    """The highest clearance (m) whose plan keeps the limits, found by halving; 0 for none."""
    low, high = 0.0, beyond
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        plan = _gentlest(paths, middle) if middle > _WORTH else None
        if plan is not None and plan.holding_effort <= _MOST_EFFORT:
            low = middle
        else:
            high = middle
    return low
