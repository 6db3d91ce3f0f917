"""Hops: the support foot leaves the ground, and lands where no other foot gets to in time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wbc.gait.swing_foot import SwingFoot

if TYPE_CHECKING:
    from wbc.gait.state import GaitState

_THRUST = 1.6  # times gravity, the acceleration of the CoM upwards in the thrust
_LONGEST_THRUST = 0.06  # s
_RISE = 0.075  # share of the CoM's height by which it may be above it before the leg is straight
_SINK = 0.03  # the same by which it is below when the foot lands
_SHORTEST_FLIGHT = 0.1  # s
_APEX = 0.06  # share of the CoM's height to which the foot rises
_EARLIEST_LANDING = 0.5  # share of the flight before which contact is that of the take-off
_LATEST_LANDING = 0.06  # s after the flight's planned end from which on it is over without contact


class Hop:
    """A hop on one foot: the support foot thrusts, flies, and lands at another place.

    While a foot stands, the DCM runs away from it as `e^(ωt)`; without any foot on the ground the
    CoM moves on evenly, and the DCM with it. The flight lasts until the CoM, thrown up with the
    speed v from d above the height at which it lands, is there,

        T = (v + √(v² + 2 g d)) / g.

    Args:
        state: of the gait, as the hop begins.
        take_off_speed: vertical speed of the CoM with which the foot leaves the ground, m/s; less
            if the thrust takes too long, or the leg is straight before.

    Attributes:
        flies: whether the foot is in the air; before, it thrusts.
        vertical_acceleration: of the CoM, upwards, m/s².
        landing: placement at which the foot is to land; the stabilizer sets it.
        foot: reference of the foot in the air; None while it thrusts.
        start: placement of the foot when it leaves the ground.
        flight: duration of the flight, s; as long as the foot thrusts, if it left the ground now.
        remaining: time of it that is left, s.
    """

    def __init__(self, state: GaitState, take_off_speed: float) -> None:
        self.flies = False
        self.vertical_acceleration = _THRUST * state.gait.gravity
        self.landing = self.start = state.stance
        self.foot: SwingFoot | None = None
        self._take_off_speed = take_off_speed
        self._height = state.normal_gait.com_height
        self._time = 0.0  # s since thrust or flight began
        self.flight = self.remaining = _SHORTEST_FLIGHT

    def update(self, state: GaitState, contacts: frozenset[str] | None, dt: float) -> bool:
        """Move on by dt; return whether the foot has landed.

        Args:
            state: feet and CoM of now.
            contacts: sides of the soles that touch the ground.
            dt: time since the last tick, s.
        """
        self._time += dt
        if self.flies:
            self.remaining = max(self.flight - self._time, 0.0)
            touches = state.support in (contacts or ())
            lands = touches and self._time > _EARLIEST_LANDING * self.flight
            return lands or self._time > self.flight + _LATEST_LANDING
        gravity, height = state.gait.gravity, state.com_height - state.stance.height
        speed = state.vertical_velocity
        drop = max(height - (1.0 - _SINK) * self._height, 0.0)
        root = math.sqrt(speed * speed + 2.0 * gravity * drop)
        self.flight = self.remaining = max((speed + root) / gravity, _SHORTEST_FLIGHT)
        self.start = state.stance
        fast = speed >= self._take_off_speed
        straight = height > (1.0 + _RISE) * self._height
        if fast or straight or self._time >= _LONGEST_THRUST:
            self._take_off(state)
        return False

    def advance(self, dt: float) -> None:
        """Move the reference of the foot in the air on by dt towards its landing place."""
        if self.foot is not None:
            self.foot.advance(dt, self.landing)

    def _take_off(self, state: GaitState) -> None:
        self.flies, self._time = True, 0.0
        self.vertical_acceleration = -state.gait.gravity
        self.foot = SwingFoot(
            self.start,
            self.landing,
            self.flight,
            _APEX * self._height,
            state.gait.touchdown_speed,
            lift=0.0,
        )
