"""Random pushes of the torso of a robot that walks."""

from __future__ import annotations

import math

import numpy as np

from wbc.robot.attitude import heading
from wbc.sim import Mujoco

#: Largest push to survive while walking, N·s/kg: forward, back, to either side.
PUSHES = {
    "talos": (0.8, 0.85, 0.5),
    "g1": (0.8, 0.85, 0.75),
    "simple_humanoid": (0.7, 0.7, 0.45),
    "icub": (0.4, 0.4, 0.25),
    "romeo": (0.4, 0.4, 0.25),
}
_PUSH_PERIOD = 5.0  # s


def share_of(robot: str, share: float) -> tuple[float, float, float]:
    """Return a share of a robot's `PUSHES`."""
    forward, back, side = PUSHES[robot]
    return share * forward, share * back, share * side


class RandomPushes:
    """Pushes the torso every 5 s, in a direction that is uniform over the horizon.

    The size is that of the ellipse through the sizes ahead, back and to the sides.

    Args:
        plant: the simulated robot.
        sizes: forward, back, to either side, N·s/kg.
        seed: of the directions.
    """

    def __init__(self, plant: Mujoco, sizes: tuple[float, float, float], seed: int) -> None:
        self._plant, self._sizes = plant, sizes
        self._random = np.random.default_rng((seed, 1))
        self._next = _PUSH_PERIOD
        self.last = "none"

    def __call__(self, time: float) -> None:
        """Push when it is time; call it before each tick."""
        if time < self._next:
            return
        self._next += _PUSH_PERIOD
        bearing = self._random.uniform(-math.pi, math.pi)
        ahead, beside = math.cos(bearing), math.sin(bearing)
        forward, back, side = self._sizes
        size = 1.0 / math.hypot(ahead / (forward if ahead > 0.0 else back), beside / side)
        robot, state = self._plant.robot, self._plant.ground_truth()
        course = bearing + heading(robot, state)
        impulse = size * robot.mass * np.array((math.cos(course), math.sin(course), 0.0))
        self._plant.push(impulse)
        self.last = f"{size:.2f} N·s/kg at {math.degrees(bearing):.0f}°"
