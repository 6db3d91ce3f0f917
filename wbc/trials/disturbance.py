"""Disturbances: what is done to the robot in a trial."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wbc.robot.attitude import heading
from wbc.sim import Mujoco
from wbc.trials.errors import TrialError

#: Names of directions, degrees counter-clockwise from the robot's heading.
DIRECTIONS = {"forward": 0.0, "left": 90.0, "back": 180.0, "right": 270.0}


@dataclass(frozen=True)
class PushDisturbance:
    """A constant force for a short time; its size is its impulse, N·s per kg of the robot.

    On a rigid body, an impulse of 1 N·s/kg at the centre of mass changes the velocity by 1 m/s.

    Attributes:
        kind: names the kind in a grid.
        duration: s.
        frame: frame at whose origin the force acts; by default the centre of mass of the torso.
    """

    kind: Literal["push"] = "push"
    duration: float = 0.1
    frame: str | None = None

    unit = "N·s/kg"

    def __post_init__(self) -> None:
        _check_duration(self.duration)

    def impulse(self, size: float, mass: float) -> float:
        """Return the impulse, N·s, of a size on a robot of a mass, kg."""
        return size * mass


@dataclass(frozen=True)
class ForceDisturbance:
    """A constant force for seconds; its size is N per kg of the robot, i.e. m/s².

    Attributes:
        kind: names the kind in a grid.
        duration: s.
        frame: see `PushDisturbance`.
    """

    kind: Literal["force"] = "force"
    duration: float = 2.0
    frame: str | None = None

    unit = "N/kg"

    def __post_init__(self) -> None:
        _check_duration(self.duration)

    def impulse(self, size: float, mass: float) -> float:
        """Return the impulse, N·s, of a size on a robot of a mass, kg."""
        return size * mass * self.duration


@dataclass(frozen=True)
class KickDisturbance:
    """A velocity that is added to the base, and so to the whole robot, at once; m/s.

    Attributes:
        kind: names the kind in a grid.
    """

    kind: Literal["kick"] = "kick"

    unit = "m/s"


Disturbance = PushDisturbance | ForceDisturbance | KickDisturbance


def apply_disturbance(
    disturbance: Disturbance, plant: Mujoco, direction: float, size: float, mass: float
) -> None:
    """Disturb the robot now, in the frame of its heading.

    Args:
        disturbance: its kind.
        plant: the simulated robot.
        direction: degrees counter-clockwise from the heading; 90 is to the left.
        size: in the unit of its kind.
        mass: nominal mass of the robot, kg.
    """
    angle = heading(plant.robot, plant.ground_truth()) + math.radians(direction)
    unit = np.array([math.cos(angle), math.sin(angle), 0.0])
    if isinstance(disturbance, KickDisturbance):
        plant.kick(size * unit)
        return
    plant.push(
        disturbance.impulse(size, mass) * unit,
        duration=disturbance.duration,
        frame=disturbance.frame,
    )


def parse_direction(direction: str | float) -> float:
    """Return a direction in degrees within [0, 360).

    Raises:
        TrialError: an unknown name.
    """
    if isinstance(direction, str):
        if direction not in DIRECTIONS:
            raise TrialError(
                f"direction '{direction}' must be one of {', '.join(DIRECTIONS)}, or a number of "
                "degrees counter-clockwise from the robot's heading"
            )
        return DIRECTIONS[direction]
    if not math.isfinite(direction):
        raise TrialError(f"direction {direction} must be a finite number of degrees")
    return float(direction) % 360.0


def direction_name(degrees: float) -> str:
    """Return the name of a direction, or its degrees."""
    names = {value: name for name, value in DIRECTIONS.items()}
    return names.get(degrees, f"{degrees:g}°")


def _check_duration(duration: float) -> None:
    if not (math.isfinite(duration) and duration > 0.0):
        raise TrialError(f"duration = {duration} s of a disturbance must be positive")
