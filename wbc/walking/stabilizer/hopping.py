"""Hops that catch a push towards the support foot."""

from __future__ import annotations

import math

from wbc.gait import SWING, GaitState, Hop, Placement, SwingFoot
from wbc.gait.footsteps import lateral_sign
from wbc.geometry.quintic import PEAK_ACCELERATION
from wbc.robot import Robot
from wbc.robot.posture import has_soles
from wbc.walking.stabilizer.support_polygon import SupportPolygon

_SIDEWAYS = 1.5  # times as far across the sole as along it that the DCM is off, at least
_LEAST_REMAINING = 0.06  # s; a foot that is about to land does, and the other one steps
_UPRIGHT = 0.26  # rad; a flight goes on with the turning that a tilted body has
_TURNS_BACK = 0.02  # share of the CoM's height that momentum away from the push moves the DCM by
_THROWN = 0.12  # times √(g h), the vertical speed up to which the foot has the ground to thrust
_BEYOND = 0.06  # share of the CoM's height by which the foot lands beyond the DCM
_REACH = 0.75  # the same that it lands away from the CoM across the sole, at most
_REACH_ALONG = 0.6  # and along it
_AWAY = 1.2  # and that the swing foot aims away from it
_ACCELERATION = 1.4  # times what a swing foot gets: its leg need not carry the body


class Hopping:
    """Decides when the support foot hops, and where it lands.

    A robot that is pushed towards its support foot early in a step has no good one: the swing foot
    can only land beside the support foot, unless it is far enough ahead or behind to cross over
    (`CrossOver`), and until the step after it the DCM, which doubles in each, is out of reach. The
    foot that stands is on the right side. It leaves the ground, the DCM moves on evenly in place of
    running away from it, and it lands beyond the DCM.

    A leg that is thrown to one side in the air turns the trunk to that side (the angular momentum
    is what it was), as the push does already. So the other leg is thrown to the other side.

    It hops if, by the linear inverted pendulum with the ZMP at the edge of the sole, the DCM will
    be out of reach of the step after the present one; once in a series of quick steps. Not if the
    body is tilted or thrown up, when there is nothing to thrust against what turns it, nor if it is
    turning back already, as in the steps after the first: the leg that is thrown would turn it on.
    Nor if the DCM is off along the sole as well, where steps are long.

    Args:
        robot: the robot.
        support: the support polygon.
        foot_acceleration: the largest that a leg's torques give its foot, m/s².
    """

    def __init__(self, robot: Robot, support: SupportPolygon, foot_acceleration: float) -> None:
        self._support = support
        self._acceleration = _ACCELERATION * foot_acceleration
        self._has_soles = has_soles(robot.soles)
        height = robot.com_height
        self._thrown = _THROWN * math.sqrt(robot.gravity * height)
        self._turns_back = _TURNS_BACK * height
        self._beyond, self._reach = _BEYOND * height, _REACH * height
        self._reach_along, self._away = _REACH_ALONG * height, _AWAY * height
        self._hopped = False

    def reset(self) -> None:
        """Forget the present series of quick steps."""
        self._hopped = False

    def begins(
        self,
        state: GaitState,
        contacts: frozenset[str] | None,
        tilt: float,
        dcm_of_com: complex,
        momentum: complex,
    ) -> bool:
        """Return whether the support foot hops from now on.

        Args:
            state: phase, feet, CoM and DCM.
            contacts: sides of the soles that touch the ground; None when it is not measured: then
                it never hops.
            tilt: angle of the body from the vertical, rad.
            dcm_of_com: the DCM without what the angular momentum adds, m.
            momentum: what the angular momentum adds, m: it hops if both are out of reach.
        """
        if not state.is_quick:
            self._hopped = False
            return False
        if self._hopped or state.phase is not SWING or not self._has_soles:
            return False
        if contacts is None or state.support not in contacts or state.swing_side in contacts:
            return False
        if not isinstance(state.swing, SwingFoot) or state.swing_is_knocked:
            return False
        if state.crossing != 0.0 or state.on_stairs or state.remaining < _LEAST_REMAINING:
            return False
        if tilt > _UPRIGHT or abs(state.vertical_velocity) > self._thrown:
            return False
        outwards = -lateral_sign(state.swing_side)
        dcm = state.stance.to_local(dcm_of_com + momentum)
        across, of_com = outwards * dcm.imag, outwards * state.stance.to_local(dcm_of_com).imag
        if across < of_com - self._turns_back or across < _SIDEWAYS * abs(dcm.real):
            return False
        self._hopped = self._is_out_of_reach(state, min(across, of_com))
        return self._hopped

    def _is_out_of_reach(self, state: GaitState, across: float) -> bool:
        """Whether the step after the present one, which ends beside the support foot, is too short.

        Args:
            state: during a swing.
            across: how far the DCM is outwards of the support sole's centre, m.
        """
        quick = state.recovery_gait
        edge = self._support.zmp_range(state.support, 1.0)[1]
        if across <= edge:
            return False
        present = state.remaining + quick.double_support
        across = edge + (across - edge) * math.exp(quick.omega * present)
        across += quick.least_width  # from here on of the sole that lands
        across = edge + (across - edge) * math.exp(quick.omega * quick.single_support)
        return across > quick.greatest_width

    def landing(self, state: GaitState, hop: Hop) -> Placement:
        """Return where the hopping foot is to land: beyond the DCM that will be there then.

        Args:
            state: CoM and DCM.
            hop: the hop.
        """
        start, outwards = hop.start, -lateral_sign(state.swing_side)
        way = hop.remaining * state.com_velocity
        com, dcm = start.to_local(state.com + way), start.to_local(state.dcm + way)
        across = min(outwards * dcm.imag + self._beyond, outwards * com.imag + self._reach)
        reach = self._reach_along
        along = min(max(dcm.real, com.real - reach), com.real + reach)
        place = complex(along, outwards * max(across, 0.0))
        farthest = self._acceleration * hop.flight**2 / PEAK_ACCELERATION
        if abs(place) > farthest:
            place *= farthest / abs(place)
        return start._replace(point=start.to_world(place))

    def away(self, state: GaitState, hop: Hop) -> Placement:
        """Return where the swing foot aims meanwhile: far away from the hopping foot."""
        place = hop.landing if hop.flies else state.stance
        return place.compose(Placement(1j * lateral_sign(state.swing_side) * self._away, 0.0))
