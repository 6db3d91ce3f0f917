"""Takes the bias off the estimated centre of mass while the robot stands."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wbc.geometry.planar import ground_point, planar_rotation
from wbc.walking import Walker
from wbc.walking.stabilizer import ComBiasEstimator

_STANDS = 0.8  # share of the weight on the soles from which on it stands
_REST = 1.0  # s of standing after steps until the CoM has come to rest
_TIME = 0.3  # s within which a bias comes into force, and out of it for steps


class ComBiasObserver:
    """Compares the estimated CoM with the measured centre of pressure; see `ComBiasEstimator`.

    Args:
        walker: whose estimate it is.

    Attributes:
        offset: by how much the estimated CoM is off, as far as that is in force: x + iy in
            heading axes, m. 0 while the robot steps.
    """

    def __init__(self, walker: Walker) -> None:
        self._walker = walker
        self.reset()

    def reset(self) -> None:
        """Start anew, at rest."""
        self._bias = ComBiasEstimator(self._walker.gait.omega)
        self._rest = _REST
        self.offset = 0j

    def update(
        self, at_rest: bool, wrenches: Mapping[str, np.ndarray], com: np.ndarray, lean: float
    ) -> None:
        """After a tick.

        Args:
            at_rest: whether it stands, on one leg or two.
            wrenches: sole name -> (6,) measured, sole axes; N, N·m.
            com: (3,) acceleration of the CoM's reference, heading axes, m/s².
            lean: acceleration of the weight's share on the left, 1/s².
        """
        dt = self._walker.dt
        self._rest = self._rest + dt if at_rest else 0.0
        wanted = 0j
        if self._rest >= _REST:
            self._compare(wrenches, com, lean)
            wanted = self._bias.value
        self.offset += (wanted - self.offset) * (dt / _TIME)

    def _compare(self, wrenches: Mapping[str, np.ndarray], wanted: np.ndarray, lean: float) -> None:
        walker = self._walker
        feet, com = walker.feet, ground_point(walker.kinematics.p_com)
        load, moment = 0.0, 0j
        for sole in walker.robot.soles:
            wrench = wrenches.get(sole.name)
            if wrench is not None and wrench[2] > 0.0:
                at = complex(-float(wrench[4]), float(wrench[3]))  # times the force
                placed = feet.of(sole.side)
                moment += float(wrench[2]) * placed.point + at * planar_rotation(placed.yaw)
                load += float(wrench[2])
        if load < _STANDS * walker.robot.weight:
            return
        back = planar_rotation(-walker.heading)
        acceleration = complex(float(wanted[0]), float(wanted[1]))
        acceleration += lean * (feet.left.point - feet.right.point) * back
        self._bias.update(walker.dt, com * back, acceleration, moment / load * back)
