"""Walking scenarios: a velocity command over time, and how far it must carry."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from wbc.runtime.report import Report

SETTLE = 1.0  # s of standing before the first step


@dataclass(frozen=True, slots=True)
class Scenario:
    """One thing that a robot has to do from standing to standing.

    Attributes:
        name: e.g. "forward 10 m at 0.5 m/s".
        velocity: commanded while it walks: forward, left (m/s), turn (rad/s).
        walk: how long the velocity is commanded, s.
        rest: how long it then has to stop and stand, s.
        measure: the report's figure that counts, e.g. the distance forward.
        goal: what the figure must reach.
        unit: of the figure.
        cruise: the least cruise speed that counts, m/s.
    """

    name: str
    velocity: tuple[float, float, float]
    walk: float
    rest: float
    measure: Callable[[Report], float]
    goal: float
    unit: str
    cruise: float = 0.0

    @property
    def duration(self) -> float:
        """Of the whole scenario, s."""
        return SETTLE + self.walk + self.rest

    def velocity_at(self, time: float) -> tuple[float, float, float]:
        """The command at a time, s."""
        if SETTLE <= time < SETTLE + self.walk:
            return self.velocity
        return (0.0, 0.0, 0.0)

    def passed(self, report: Report) -> bool:
        """Survived, went far and fast enough, no QP failure, no limit broken."""
        return (
            report.survived
            and self.measure(report) >= self.goal
            and report.cruise_speed_m_s >= self.cruise
            and report.qp_failures == 0
            and report.joint_limit_excess_rad <= 1e-3
            and report.torque_excess_nm <= 0.0
        )


# The first and last steps are slower than the command: their time is added to the walk.
_START_AND_STOP = 1.5
_TURN_START_AND_STOP = 0.6


def forward(distance: float, speed: float, rest: float = 3.0, cruise: float = 0.0) -> Scenario:
    """Walk straight on at a commanded speed, and at least at `cruise` as measured (m/s).

    A foot that finds the ground late makes its step last longer, so the robot is a little
    slower than the command.
    """
    sign = math.copysign(1.0, speed)
    name = f"{'forward' if speed > 0 else 'backward'} {distance:g} m at {abs(speed):g} m/s"
    walk = distance / abs(speed) + _START_AND_STOP
    return Scenario(
        name,
        (speed, 0.0, 0.0),
        walk,
        rest,
        lambda r: sign * r.displacement_m[0],
        distance,
        "m",
        cruise,
    )


def sideways(distance: float, speed: float, rest: float = 3.0) -> Scenario:
    """Walk to the left."""
    walk = distance / speed + _START_AND_STOP
    name = f"sideways {distance:g} m at {speed:g} m/s"
    return Scenario(
        name, (0.0, speed, 0.0), walk, rest, lambda r: r.displacement_m[1], distance, "m"
    )


def turn(degrees: float, rate: float, rest: float = 3.0) -> Scenario:
    """Turn left in place."""
    walk = math.radians(degrees) / rate + _TURN_START_AND_STOP
    return Scenario(
        f"turn {degrees:g}° in place",
        (0.0, 0.0, rate),
        walk,
        rest,
        lambda r: math.degrees(r.turned_rad),
        degrees,
        "°",
    )


def circle(radius: float, speed: float, rest: float = 3.0) -> Scenario:
    """Walk once around a circle to the left."""
    walk = 2.0 * math.pi * radius / speed + _START_AND_STOP
    return Scenario(
        f"circle of {radius:g} m radius",
        (speed, 0.0, speed / radius),
        walk,
        rest,
        lambda r: math.degrees(r.turned_rad),
        360.0,
        "°",
    )


def stop_and_stand(speed: float, rest: float = 10.0) -> Scenario:
    """Walk for a few steps, stop, and stand."""
    return Scenario(
        f"stop and stand {rest:g} s",
        (speed, 0.0, 0.0),
        4.0,
        rest,
        lambda r: r.duration_s - SETTLE - 4.0,
        rest - 0.1,
        "s",
    )
