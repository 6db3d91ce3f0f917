"""Walking scenarios: a velocity command over time, and the distance that must be reached."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from wbc.errors import GaitError
from wbc.runtime.report import Report

STANDING_TIME = 1.0  # s of standing before the first step


@dataclass(frozen=True, slots=True)
class Scenario:
    """A walk from standing to standing, and what counts as success.

    Attributes:
        name: e.g. "forward 10 m at 0.5 m/s".
        velocity: commanded while walking: forward, left (m/s), turn (rad/s).
        walk_time: duration of the command, s.
        stand_time: duration of stopping and standing afterwards, s.
        metric: the figure of the report that counts, e.g. the distance walked forward.
        goal: value that the metric must reach, in `unit`.
        unit: unit of the metric.
        min_cruise_speed: lowest cruise speed that passes, m/s.
    """

    name: str
    velocity: tuple[float, float, float]
    walk_time: float
    stand_time: float
    metric: Callable[[Report], float]
    goal: float
    unit: str
    min_cruise_speed: float = 0.0

    @property
    def duration(self) -> float:
        """Duration of the whole scenario, s."""
        return STANDING_TIME + self.walk_time + self.stand_time

    def velocity_at(self, time: float) -> tuple[float, float, float]:
        """Return the commanded velocity (m/s, m/s, rad/s) at `time` (s)."""
        if STANDING_TIME <= time < STANDING_TIME + self.walk_time:
            return self.velocity
        return (0.0, 0.0, 0.0)

    def passed(self, report: Report) -> bool:
        """Whether the robot survived, went far and fast enough, and no QP or limit failed."""
        return (
            report.survived
            and self.metric(report) >= self.goal
            and report.cruise_speed_m_s >= self.min_cruise_speed
            and report.qp_failures == 0
            and report.joint_limit_excess_rad <= 1e-3
            and report.torque_excess_nm <= 0.0
        )


# The first and last steps are slower than the command: their time is added to the walk.
_START_AND_STOP = 1.5
_TURN_START_AND_STOP = 0.6


def forward(
    distance: float, speed: float, stand_time: float = 3.0, min_cruise_speed: float = 0.0
) -> Scenario:
    """Walk forward, or backward at a negative speed.

    A foot that touches down late makes its step last longer, so the robot is a little slower than
    the command.

    Args:
        distance: distance that must be reached, m.
        speed: commanded, m/s.
        stand_time: duration of stopping and standing afterwards, s.
        min_cruise_speed: lowest measured cruise speed that passes, m/s.

    Raises:
        GaitError: the speed is zero or not finite, or the distance not positive.
    """
    sign = math.copysign(1.0, speed)
    name = f"{'forward' if speed > 0 else 'backward'} {distance:g} m at {abs(speed):g} m/s"
    walk = _travel_time(distance, abs(speed)) + _START_AND_STOP
    return Scenario(
        name,
        (speed, 0.0, 0.0),
        walk,
        stand_time,
        lambda r: sign * r.displacement_m[0],
        distance,
        "m",
        min_cruise_speed,
    )


def sideways(distance: float, speed: float, stand_time: float = 3.0) -> Scenario:
    """Walk `distance` (m) to the left at `speed` (m/s)."""
    walk = _travel_time(distance, speed) + _START_AND_STOP
    name = f"sideways {distance:g} m at {speed:g} m/s"
    return Scenario(
        name, (0.0, speed, 0.0), walk, stand_time, lambda r: r.displacement_m[1], distance, "m"
    )


def turn(degrees: float, rate: float, stand_time: float = 3.0) -> Scenario:
    """Turn left in place by `degrees` at `rate` (rad/s)."""
    walk = _travel_time(math.radians(degrees), rate) + _TURN_START_AND_STOP
    return Scenario(
        f"turn {degrees:g}° in place",
        (0.0, 0.0, rate),
        walk,
        stand_time,
        lambda r: math.degrees(r.turned_rad),
        degrees,
        "°",
    )


def circle(radius: float, speed: float, stand_time: float = 3.0) -> Scenario:
    """Walk once around a circle of `radius` (m) to the left at `speed` (m/s)."""
    walk = _travel_time(2.0 * math.pi * radius, speed) + _START_AND_STOP
    return Scenario(
        f"circle of {radius:g} m radius",
        (speed, 0.0, speed / radius),
        walk,
        stand_time,
        lambda r: math.degrees(r.turned_rad),
        360.0,
        "°",
    )


def stop_and_stand(speed: float, stand_time: float = 10.0) -> Scenario:
    """Walk for 4 s at `speed` (m/s), stop, and stand for `stand_time` (s)."""
    return Scenario(
        f"stop and stand {stand_time:g} s",
        (speed, 0.0, 0.0),
        4.0,
        stand_time,
        lambda r: r.duration_s - STANDING_TIME - 4.0,
        stand_time - 0.1,
        "s",
    )


def _travel_time(distance: float, speed: float) -> float:
    """Time for a distance (m or rad) at a speed (m/s or rad/s), s."""
    if not (math.isfinite(distance) and math.isfinite(speed) and distance > 0.0 and speed > 0.0):
        raise GaitError(
            f"a scenario of {distance:g} m (or rad) at {speed:g} m/s (or rad/s) never ends; "
            "distance and speed must be finite and not zero"
        )
    return distance / speed
