"""Fall controller: damped joints and knees that give way."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.robot import Robot
from wbc.state import State

#: Time constant with which a joint's motion decays, s.
_DECAY_TIME = 0.1
#: Natural frequency with which the knees bend, rad/s.
_KNEE_RATE = 5.0
#: Natural frequency with which a robot that lies keeps its posture, rad/s.
_POSTURE_RATE = 10.0
#: A robot lies when its body has turned more slowly than this, rad/s, for this long, s.
_STILL_RATE, _STILL_TIME = 0.5, 0.3
#: Share of the effort limits that is used.
_TORQUE_SHARE = 0.5


class FallController:
    """Lets a robot fall softly.

    It tracks nothing as long as the body turns. Each joint is damped, and the knees are drawn to
    the middle of their range, which lowers the centre of mass and with it the energy of the impact:

        τ = −I q̇ / T + I κ² (q_mid − q)    (second term: knees only),   |τ| ≤ τ_max / 2,

    with I the inertia that the joint moves in the nominal posture (the diagonal of the mass matrix,
    kg·m²), T = 0.1 s and κ = 5 rad/s. Damping cannot make the limbs flail, whatever they hit (after
    the damping mode of commercial humanoids, and K. Fujiwara et al., *UKEMI: falling motion control
    to minimize damage to biped humanoid robot*, IROS 2002, for the bent knees).

    Damping alone lets a limb that ends up in the air sink for many seconds. So once the body has
    turned more slowly than 0.5 rad/s for 0.3 s, the other joints are drawn to where they are then,
    with κ = 10 rad/s, until it turns faster again.

    Args:
        robot: the robot.
        dt: control period, s.
        knees: indices of the knees among the actuated joints.
    """

    def __init__(self, robot: Robot, dt: float, knees: Collection[int]) -> None:
        model = robot.model
        inertia = np.diag(pin.crba(model, model.createData(), robot.q_nominal))[6:]
        self._dt = dt
        self._damping = inertia / _DECAY_TIME
        self._wanted = np.zeros(robot.na)
        self._falling_stiffness = np.zeros(robot.na)
        for knee in knees:
            middle = 0.5 * float(robot.q_min[knee] + robot.q_max[knee])
            if np.isfinite(middle):
                self._wanted[knee] = middle
                self._falling_stiffness[knee] = inertia[knee] * _KNEE_RATE**2
        self._free = self._falling_stiffness == 0.0
        posture_stiffness = inertia * _POSTURE_RATE**2
        self._lying_stiffness = np.where(self._free, posture_stiffness, self._falling_stiffness)
        self._still_ticks, self._least_ticks = 0, max(1, round(_STILL_TIME / dt))
        self._limit = _TORQUE_SHARE * robot.tau_max
        self._at_rest = np.zeros(robot.nv)

    def reset(self) -> None:
        """Forget that the robot lay, for a new fall."""
        self._still_ticks = 0

    def command(self, state: State) -> Command:
        """Return the command of one tick; its acceleration is zero, which it does not predict."""
        q, v = state.q[7:], state.v[6:]
        still = np.abs(state.v[3:6]).max() <= _STILL_RATE
        self._still_ticks = self._still_ticks + 1 if still else 0
        if self._still_ticks == self._least_ticks:
            self._wanted[self._free] = q[self._free]
        lies = self._still_ticks >= self._least_ticks
        stiffness = self._lying_stiffness if lies else self._falling_stiffness
        tau = stiffness * (self._wanted - q) - self._damping * v
        tau = np.clip(tau, -self._limit, self._limit)
        return Command(tau, self._at_rest.copy(), {}, q + self._dt * v, v.copy())
