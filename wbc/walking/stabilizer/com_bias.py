"""Bias of the estimated centre of mass, observed from the measured force of the ground."""

from __future__ import annotations

import cmath

from wbc.walking.feet import GroundReaction
from wbc.walking.ground_kinematics import CentroidalMotion

_TIME = 1.5  # s, time constant of the bias
_FIRST = 0.5  # s of readings that the first ones are averaged with
_SMOOTHING = 0.05  # s, time constant of the momentum's rate
_MAX_BIAS = 0.03  # m


class ComBiasEstimator:
    """Constant error of the estimated CoM over the soles, on the ground, m.

    An accelerometer that is off by b tilts the estimate by b/g, and the CoM with it. The angular
    momentum k about the ground point c below the CoM changes by the moment of the ground's force
    f_z at the centre of pressure p: with horizontal moments turned into the ground plane,

        k̇ = (c − p) f_z + m ż ċ,

    whatever the robot does. The rest of this equation with the estimated ĉ, over the weight,

        (ĉ − p) f_z / (m g) + ż ċ / g − k̇ / (m g),

    is the error of ĉ. A linear inverted pendulum in its place, k = m z ċ, would take the momentum
    of legs that sway on standing feet for an error, a seventh of `c̈ / ω²` on Talos.

    The momentum and the rest pass the same low-pass of 0.05 s, so that the rate of the momentum
    is the difference to its low-pass; pushes average out in a second low-pass (the integral term
    of Caron et al., Stair climbing stabilization of the HRP-4 humanoid robot, ICRA 2019, removes
    the same bias by way of the DCM error). The bias is estimated at rest and kept while the robot
    steps.

    Args:
        gravity: g, m/s².
        dt: time between two readings, s.
    """

    def __init__(self, gravity: float, dt: float) -> None:
        self._gravity, self._dt = gravity, dt
        self.reset()

    def reset(self) -> None:
        """Start anew, without a known bias."""
        self._bias = 0j  # heading axes, m
        self._elapsed = 0.0
        self._momentum: complex | None = None  # low-passed, world axes, over the weight, m·s
        self._offset = 0j  # low-passed rest of the equation, world axes, m

    def update(
        self,
        com: CentroidalMotion,
        reaction: GroundReaction | None,
        heading: float,
        hand_offset: complex = 0j,
    ) -> complex:
        """Take in one reading; returns the bias in world axes, m.

        Args:
            com: estimated motion of the centre of mass.
            reaction: measured force of the ground; None keeps the bias: the robot steps, or
                nothing is measured.
            heading: axes in which the bias is constant, rad.
            hand_offset: by how much known forces on the hands move the pivot off the ZMP, m.
        """
        if reaction is None:
            self._momentum = None
            return self._bias * cmath.rect(1.0, heading)
        to_world = cmath.rect(1.0, heading)
        offset = (com.point - reaction.cop) * reaction.load - hand_offset
        offset += com.velocity * (com.vertical_velocity / self._gravity)
        if self._momentum is None:
            self._momentum, self._offset = com.momentum, offset
        dt = self._dt
        share = min(dt / _SMOOTHING, 1.0)
        self._momentum += share * (com.momentum - self._momentum)
        self._offset += share * (offset - self._offset)
        error = self._offset - (com.momentum - self._momentum) / _SMOOTHING
        size = abs(error)
        if size > _MAX_BIAS:  # a push, not a bias
            error *= _MAX_BIAS / size
        self._elapsed += dt
        share = dt / min(_TIME, _FIRST + self._elapsed)
        self._bias += share * (error * to_world.conjugate() - self._bias)
        return self._bias * to_world
