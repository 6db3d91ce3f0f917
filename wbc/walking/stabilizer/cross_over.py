"""Cross-over steps: the swing foot lands beyond the support foot."""

from __future__ import annotations

import math

from wbc.gait import GaitParameters, GaitState, Placement, SwingFoot
from wbc.gait.footsteps import clamp_footstep, lateral_sign
from wbc.geometry.planar import planar_rotation
from wbc.robot import Robot
from wbc.walking.stabilizer.step_adjustment import easy_step

_CLEARANCE = 0.03  # m between the toe of one sole and the heel of the other
_BEYOND = 0.15  # share of the legs' length by which a foot lands beyond the CoM, at most
_FARTHEST = 0.5  # the same beyond the other foot
_WORTHWHILE = 0.1  # m that it has to gain across the sole, at least
_COST = 3.0  # times what it gains across that it may land off along the sole, at most
_DECELERATION = 5.5  # times gravity: what the hips stop a foot by without the trunk
_LAG = 0.015  # s by which a foot follows its reference
_CAUGHT = 0.75  # share of what any number of quick steps catch that it may land off along the sole
_HALFWAY = 0.16  # share of its speed times its time by which a quintic is farther halfway, 5/32
_AHEAD = 0.04  # m that the foot still has to move forward or back until it passes, at most
_SCRAPE = 0.01  # m by which it may be nearer than that halfway
_CROSSED = 0.5  # share of the least width: a foot that is nearer has crossed over


class CrossOver:
    """Where a foot lands that has to pass the support foot, and on which side it passes.

    A robot that is pushed towards its support foot needs a landing place beyond that foot. A step
    that ends beside it leaves the whole error, which doubles, to the next one; one that crosses
    over takes as much off it as it lands beyond. Soles and shins pass each other only while one is
    ahead of the other by a sole's length, so the foot crosses in front if it already is in front,
    and behind if it is behind, and can stop there. The step after it comes back the same way. A
    foot that a blow has thrown past the other one need not come back before it lands.

    It lands a distance d behind or ahead of the wanted place, and the DCM is so much farther from
    it, on the other side, than the b that the plan leaves it there. The steps after it have to
    catch that: with the length R of an easy step, that of the ZMP, m, and the growth E of the DCM
    in a step, as many as it takes,

        d ≤ 0.75 (R / (E − 1) − b + m)

    (N-step capturability, Koolen et al., IJRR 2012; at the bound itself no step would leave less).

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._length = sum(sole.half_length for sole in robot.soles) + _CLEARANCE
        self._beyond = _BEYOND * robot.leg_length
        self._farthest_beyond = _FARTHEST * robot.leg_length
        self._sole = min(sole.half_length for sole in robot.soles)
        self._half_width = min(sole.half_width for sole in robot.soles)

    def side(self, state: GaitState, wanted: complex, dcm_offset: float) -> float:
        """Return on which side of the support foot to cross over: 1 in front, −1 behind, 0 not.

        Args:
            state: during a swing.
            wanted: where the foot is to land, in the support sole's axes, m.
            dcm_offset: how far ahead of that place along the support sole the DCM is planned to be
                at touchdown, m.
        """
        sign, least = lateral_sign(state.swing_side), state.recovery_gait.least_width
        foot = state.stance.to_local(state.other_foot.point)
        gain = least - max(sign * wanted.imag, -self._farthest(state))
        side = math.copysign(1.0, foot.real)
        if gain < _WORTHWHILE or not self._passes(state, foot, side):
            return 0.0
        off = self._length - side * wanted.real
        caught = self._caught_after(state.recovery_gait, -side * dcm_offset)
        return side if off < min(caught, _COST * gain) else 0.0

    def _passes(self, state: GaitState, foot: complex, side: float) -> bool:
        """Return whether a foot can pass the support foot, or has: a blow may have thrown it past.

        Args:
            state: during a swing.
            foot: where the swing foot is, in the support sole's axes, m.
            side: 1 if it is in front of the support foot, −1 if it is behind.
        """
        width = lateral_sign(state.swing_side) * foot.imag
        apart = abs(foot.real) - self._length + _AHEAD
        if state.swing_is_knocked and width < 0.0:
            return apart >= 0.0
        if width < state.recovery_gait.least_width:
            return False
        return apart >= _stopping_distance(state, side)

    def goes_on(self, state: GaitState, wanted: complex) -> bool:
        """Return whether a foot that crosses over still has to, or is about to; see `side`."""
        sign, least = lateral_sign(state.swing_side), state.recovery_gait.least_width
        foot = state.stance.to_local(state.other_foot.point)
        return min(sign * wanted.imag, sign * foot.imag) < least

    def _caught_after(self, quick: GaitParameters, dcm_offset: float) -> float:
        """Return how far off the DCM may be, beside its offset b, for quick steps to catch it, m.

        Args:
            quick: parameters of the quick steps.
            dcm_offset: planned one at touchdown, b, in the direction in which the DCM is off, m.
        """
        growth = math.exp(quick.omega * quick.step_duration)
        return _CAUGHT * (easy_step(quick) / (growth - 1.0) - dcm_offset + self._sole)

    def _way_past(self, state: GaitState, side: float) -> float:
        """Return how far ahead or behind a foot has to land to be past the other one halfway, m.

        On a quintic from x with the speed v to rest at x_T it is then at

            x(T/2) = (x + x_T) / 2 + 5/32 v T.

        Args:
            state: during a swing that crosses over.
            side: 1 if the swing foot is in front, −1 if it is behind.
        """
        foot = state.stance.to_local(state.other_foot.point)
        if lateral_sign(state.swing_side) * foot.imag < 0.0:  # it already is
            return self._length
        way = _speed_towards(state, side) * state.remaining
        past = self._length - _SCRAPE + _HALFWAY * way
        return max(self._length, 2.0 * past - side * foot.real)

    def _farthest(self, state: GaitState) -> float:
        """Return how far beyond the support foot the swing foot may land, m.

        Thighs and pelvis bound how far legs cross, and the pelvis goes along with the centre of
        mass: the foot may land a little beyond where that will be, by the linear inverted pendulum
        on the edge of the support sole,

            c(t) = p + ((ξ − p) e^(ωt) + (2 (c − p) − (ξ − p)) e^(−ωt)) / 2.
        """
        inwards = lateral_sign(state.swing_side)
        com, dcm = (-inwards * state.stance.to_local(p).imag for p in (state.com, state.dcm))
        edge = self._half_width
        growth = math.exp(state.gait.omega * state.remaining)
        rest = 2.0 * (com - edge) - (dcm - edge)
        com_then = edge + 0.5 * ((dcm - edge) * growth + rest / growth)
        return min(max(com_then + self._beyond, self._beyond), self._farthest_beyond)

    def nearest(self, state: GaitState, wanted: Placement) -> Placement:
        """Return the nearest landing place that the leg reaches without touching the other one.

        Args:
            state: during a swing.
            wanted: where the foot is to land.
        """
        stance, sign, limits = state.stance, lateral_sign(state.swing_side), state.limits
        least = state.recovery_gait.least_width
        side, width, past = state.crossing, math.inf, self._length
        if side != 0.0:
            past = self._way_past(state, side)
            width = max(-self._farthest(state), sign * stance.to_local(wanted.point).imag)
        else:
            foot = stance.to_local(state.other_foot.point)
            if sign * foot.imag < _CROSSED * least and 2.0 * abs(foot.real) > self._length:
                side = math.copysign(1.0, foot.real)  # it comes back from a cross-over step
        place = clamp_footstep(stance, state.swing_side, wanted, limits)
        if side == 0.0:
            return place
        local = stance.to_local(place.point)
        forward = side * max(past, side * local.real)
        width = min(width, sign * local.imag)
        return place._replace(point=stance.to_world(complex(forward, sign * width)))


def _stopping_distance(state: GaitState, side: float) -> float:
    """Return how far the swing foot goes on towards the support foot until it stops, m.

    Args:
        state: during a swing.
        side: 1 if the swing foot is in front, −1 if it is behind.
    """
    speed = _speed_towards(state, side)
    return speed * _LAG + 0.5 * speed * speed / (_DECELERATION * state.gait.gravity)


def _speed_towards(state: GaitState, side: float) -> float:
    """Return the speed along the support sole with which the swing foot comes nearer to it, m/s.

    It is 0 if the foot moves away.
    """
    if not isinstance(state.swing, SwingFoot):
        return 0.0
    x, y, *_ = state.swing.motion.velocity.tolist()
    velocity = complex(x, y) * planar_rotation(-state.stance.yaw)
    return max(-side * velocity.real, 0.0)
