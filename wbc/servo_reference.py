"""References of joint servos, integrated from the commands of a controller."""

from __future__ import annotations

import math

import numpy as np

from wbc.command import Command, Status
from wbc.errors import ServoError
from wbc.servo import ServoCommand, ServoGains

_SLOW = 0.1  # rad/s below which friction is compensated in part: its direction is not certain


class ServoReference:
    """Joint references for servos, integrated from the accelerations of commands:

        v ← v + dt (a + λ_v (v_target − v)),   q ← q + dt (v + λ_q (q_target − q)).

    The targets of a command start from the measured state, so that servos which track them resist
    nothing. The integral resists what the model does not know, such as friction, and leaks towards
    the measured state, so that it does not drift from what the controller sees. Without contacts
    (in flight or in a fall), and when a tick's QP failed, it is the targets themselves.

    Friction as it is known from an identification is compensated by the feed-forward torque,

        tau ← tau + friction tanh(v / 0.1 rad/s),

    at the velocity of the reference, which has no noise. What is left of it the integral bears.

    Args:
        gains: gains of the servos.
        dt: control period, s.
        friction: (na,) Coulomb friction of the joints to compensate, N·m; none by default. Less
            than the joints have is safe, more makes them chatter.
        position_leak: λ_q, 1/s.
        velocity_leak: λ_v, 1/s.

    Raises:
        ServoError: a period or leak that is not positive, or friction that is not finite and >= 0
            for every joint.
    """

    def __init__(
        self,
        gains: ServoGains,
        dt: float,
        *,
        friction: np.ndarray | None = None,
        position_leak: float = 5.0,
        velocity_leak: float = 10.0,
    ) -> None:
        for name, value in (
            ("dt", dt),
            ("position_leak", position_leak),
            ("velocity_leak", velocity_leak),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise ServoError(f"ServoReference: {name} = {value} must be positive and finite")
        self.gains = gains
        self._friction = np.zeros_like(gains.kp) if friction is None else np.asarray(friction)
        if self._friction.shape != gains.kp.shape or not (
            np.isfinite(self._friction).all() and (self._friction >= 0.0).all()
        ):
            raise ServoError(
                f"ServoReference: friction = {friction} must be {gains.kp.size} finite numbers "
                ">= 0, N·m"
            )
        self._dt = dt
        self._position_leak = min(dt * position_leak, 1.0)
        self._velocity_leak = min(dt * velocity_leak, 1.0)
        self._q: np.ndarray | None = None
        self._v = np.zeros_like(gains.kp)

    def reset(self) -> None:
        """Start anew from the next command."""
        self._q = None

    def update(self, command: Command) -> ServoCommand:
        """Return the command to the servos of one tick, from the controller's."""
        if self._q is None or command.status is not Status.OK or not command.wrenches:
            self._q, self._v = command.q_target, command.v_target
        else:
            v = self._v + self._dt * command.acceleration[6:]
            self._v = v + self._velocity_leak * (command.v_target - v)
            q = self._q + self._dt * self._v
            self._q = q + self._position_leak * (command.q_target - q)
        tau = command.tau + self._friction * np.tanh(self._v / _SLOW)
        return ServoCommand(self._q, self._v, tau, self.gains.kp, self.gains.kd)
