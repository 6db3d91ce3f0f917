"""What a tour consists of: its parameters, and the waypoints and punches of one seed."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from wbc.geometry.planar import Placement
from wbc.robot import Robot

#: The random streams of a seed: each part of a tour is the same whatever the others draw.
_WAYPOINTS, _PUNCHES, ARMS = range(3)


@dataclass(frozen=True, slots=True)
class TourParameters:
    """Parameters of a tour; the defaults are those of the public benchmark.

    Attributes:
        duration: duration of the tour, s.
        waypoints: number of waypoints; each has an equal share of the duration.
        radius: radius of the disc on which the waypoints are, m.
        centre: distance of the disc's centre in front of the robot's start, m.
        first_punch: time of the first punch after the start of the tour, s; the others follow at
            the same time after each waypoint is given.
        punch_duration: s.
        max_force: largest force of a punch, N.
        first_force: the same at the first punch, as a share of `max_force`.
        force_ramp: time over which the ceiling rises to `max_force`, s.
        least_force: smallest force of a punch, as a share of the ceiling.
        standing_time: time that the robot stands before the tour, s.
        friction: Coulomb coefficient of the ground.
    """

    duration: float = 90.0
    waypoints: int = 18
    radius: float = 1.0
    centre: float = 0.3
    first_punch: float = 0.1
    punch_duration: float = 0.08
    max_force: float = 500.0
    first_force: float = 1.0 / 3.0
    force_ramp: float = 60.0
    least_force: float = 0.5
    standing_time: float = 1.0
    friction: float = 1.0

    @property
    def segment(self) -> float:
        """Time for one waypoint, s."""
        return self.duration / self.waypoints


@dataclass(frozen=True, slots=True)
class Punch:
    """A constant force for a moment.

    Attributes:
        time: time since the start of the tour, s.
        joint: name of the joint at whose origin it acts, on the link that the joint moves.
        force: (3,) world axes, N.
    """

    time: float
    joint: str
    force: np.ndarray

    def __str__(self) -> str:
        return f"{float(np.linalg.norm(self.force)):.0f} N at {self.joint}"


@dataclass(frozen=True, slots=True)
class Tour:
    """The waypoints and punches of one seed.

    Attributes:
        seed: the seed.
        parameters: parameters of the tour.
        waypoints: in the frame of the robot's start, in the order of their times.
        punches: in the order of their times.
    """

    seed: int
    parameters: TourParameters
    waypoints: tuple[Placement, ...]
    punches: tuple[Punch, ...]


def draw_direction(rng: np.random.Generator, elevation: float = -0.5 * math.pi) -> np.ndarray:
    """Return a unit vector (3,), uniform on the part of the sphere above an elevation, rad."""
    z, bearing = rng.uniform(math.sin(elevation), 1.0), rng.uniform(0.0, math.tau)
    across = math.sqrt(1.0 - z * z)
    return np.array((across * math.cos(bearing), across * math.sin(bearing), z))


def draw_tour(robot: Robot, seed: int, parameters: TourParameters | None = None) -> Tour:
    """Return the tour of a seed.

    Waypoints are uniform on the disc, their headings over all directions. A punch hits a random
    joint in a direction that is uniform on the sphere, with

        |F| = ceiling · U(least_force, 1),
        ceiling = max_force · (first_force + (1 − first_force) · min(t / force_ramp, 1)).

    Args:
        robot: the robot.
        seed: seed of the tour.
        parameters: parameters of the tour; those of the public benchmark by default.
    """
    p = TourParameters() if parameters is None else parameters
    places = np.random.default_rng((seed, _WAYPOINTS))
    waypoints = []
    for _ in range(p.waypoints):
        radius, bearing = p.radius * math.sqrt(places.random()), places.uniform(0.0, math.tau)
        point = p.centre + cmath.rect(radius, bearing)
        waypoints.append(Placement(point, float(places.uniform(-math.pi, math.pi))))
    blows = np.random.default_rng((seed, _PUNCHES))
    punches = []
    for i in range(p.waypoints):
        since_first = i * p.segment
        ramp = min(since_first / p.force_ramp, 1.0)
        ceiling = p.max_force * (p.first_force + (1.0 - p.first_force) * ramp)
        joint = robot.joint_names[blows.integers(robot.na)]
        direction = draw_direction(blows)
        force = ceiling * blows.uniform(p.least_force, 1.0) * direction
        punches.append(Punch(p.first_punch + since_first, joint, force))
    return Tour(seed, p, tuple(waypoints), tuple(punches))
