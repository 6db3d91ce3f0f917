"""Limits that the safety layer enforces."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wbc.hardware.errors import HardwareError


@dataclass(frozen=True, slots=True)
class SafetyLimits:
    """Limits on what a robot may do and on what its messages may say.

    Attributes:
        torque: largest torque of a servo, as a share of the joint's limit.
        torque_rise: time in which a torque may rise from zero to the joint's limit, s.
        velocity: largest measured velocity of a joint, as a share of its limit.
        position_margin: how far a joint may be measured beyond its range, rad.
        jump_margin: change of an encoder from one reading to the next beyond what the joint's
            velocity limit allows, rad.
        tilt: largest angle of the base from the upright, rad.
        silence: time without a valid state message, s.
        frozen: time in which the readings repeat themselves exactly, s.
        torque_error: norm of the difference of the measured torques from those commanded, as a
            share of the norm of these.
        unanswered: time for which that difference may be larger, s.
        lateness: delay of a tick behind the robot's clock, s; a pause of 20 ms is at least 18 ms of
            it, because it begins in a period of 2 ms.
        start_distance: largest distance of a joint from the nominal posture at the start, rad.
        start_velocity: largest velocity of a joint at the start, rad/s.
        tracking: largest distance of a joint from its reference on the way to the posture, rad.
        posture_error: the same once the posture is held, rad.

    Raises:
        HardwareError: a limit that is not positive and finite.
    """

    torque: float = 1.0
    torque_rise: float = 0.01
    velocity: float = 1.2
    position_margin: float = 0.1
    jump_margin: float = 0.05
    tilt: float = 0.8
    silence: float = 0.02
    frozen: float = 0.01
    torque_error: float = 0.6
    unanswered: float = 0.02
    lateness: float = 0.0175
    start_distance: float = 1.0
    start_velocity: float = 0.5
    tracking: float = 0.5
    posture_error: float = 0.2

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise HardwareError(f"SafetyLimits: {name} = {value} must be positive and finite")
