"""The share of its weight that a robot's feet carry."""

from __future__ import annotations

from wbc.estimation.wrench_observer import WrenchObserver
from wbc.measurement import Measurement
from wbc.robot import Robot

_ENOUGH = 0.6
_SMOOTHING = 0.5  # s: a gantry that is being lowered is slack soon after
_GANTRY = 10.0  # weights, or levers of the weight, m: what may hang the robot by its base


class FootLoad:
    """Finds how much of a robot's weight its feet carry, from the torques of its legs.

    Args:
        robot: the robot.
        dt: period of `update`, s.
    """

    def __init__(self, robot: Robot, dt: float) -> None:
        self._observer = WrenchObserver(robot, dt, force_error=_GANTRY, moment_error=_GANTRY)
        self._weight, self._share = robot.weight, min(dt / _SMOOTHING, 1.0)
        self._load = 0.0

    def update(self, m: Measurement) -> float | None:
        """Return the smoothed normal forces of the soles over the weight.

        Returns:
            That share; None if the robot does not measure its joint torques.
        """
        if m.joint_torque is None:
            return None
        wrenches = self._observer.update(m, m.joint_position, m.joint_velocity)
        force = float(sum(wrench[2] for wrench in wrenches.values()))
        self._load += self._share * (force / self._weight - self._load)
        return self._load


def feet_carry(load: float | None) -> bool:
    """Return whether the feet carry 60 % of the weight; True if the robot does not measure it."""
    return load is None or load > _ENOUGH
