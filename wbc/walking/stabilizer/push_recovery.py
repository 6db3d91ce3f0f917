"""Push recovery: quick steps when the soles on the ground cannot catch the DCM."""

from __future__ import annotations

import math
from collections.abc import Callable

from wbc.gait import DcmReference, GaitState, Placement, SwingFoot, ZmpSegment
from wbc.gait.footsteps import lateral_sign
from wbc.gait.planners.dcm import dcm_after
from wbc.gait.strength import foot_acceleration
from wbc.geometry.planar import planar_rotation
from wbc.robot import Robot
from wbc.walking.stabilizer.cross_over import CrossOver
from wbc.walking.stabilizer.disturbance import dcm_ahead, lasting_rate
from wbc.walking.stabilizer.step_adjustment import footstep_adjustment, uncaught_dcm_error
from wbc.walking.stabilizer.support_choice import first_swing, has_to_return
from wbc.walking.stabilizer.support_polygon import SupportPolygon

# How fast a swing foot gets, times what the legs' torques give it with the body at rest.
_SWING_ACCELERATION = 1.3
_LEAST_REMAINING = 0.1  # s that a shortened swing has left, at least
_LANDS = 0.02  # s before its end in which a swing foot is as good as on the ground
_OUT_OF_REACH = 0.05  # share of the CoM height by which a landing place has to be out of reach
_WITHIN_REACH = 0.01, 0.03  # m, the same of a step of the normal gait: to return to it, to stay
_LEAST_ERROR = 0.05  # m of DCM error that shorten a transfer or make a robot step, at least
_USED_SUPPORT = 0.5  # share of the way to the support's edge that the DCM may go while standing
_LOOKAHEAD = 0.07  # s for which a push is taken to last on, of a robot that has to choose a side
_SWING_LOOKAHEAD = 0.05  # s, the same of a robot whose swing foot goes on to another place
_USED_SOLE = 0.9  # the same on one leg
_HOLD = 0.01  # s by which a transfer is prolonged at a time
_LONGEST_HOLD = 1.0  # s
_INSIDE = 0.02  # share of the CoM height by which the DCM has to be off toe and heel, to wait there

#: The wanted DCM for a landing place of the swing foot, or, given None, for the planned one.
Reference = Callable[[Placement | None], DcmReference]


class PushRecovery:
    """Changes from the normal gait to the recovery gait, and back.

    Every tick asks what error of the DCM a ZMP within the support would leave at the end of the
    phase, and whether the next footstep can make up for it. If not,

    - a swing is shortened, and lands where it catches most; one that is about to end goes on to
      there, or ends in any case, and one whose foot was knocked lasts until the foot gets there;
    - a transfer is prolonged as long as both feet catch the DCM; else it is shortened, or the
      weight goes back to the foot that it comes from;
    - a robot that stands steps with the foot that catches more, or with the one it holds up.

    The steps that follow are planned with the recovery gait, until a swing can end so that the
    normal gait goes on from it. The landing place itself is that of the step adjustment.

    On stairs, where another foothold than the given one may be an edge, no step is quick.

    Args:
        robot: the robot.
        support: the support polygon.

    Attributes:
        foot_acceleration: largest horizontal acceleration that a swing foot is taken to get, m/s².
    """

    def __init__(self, robot: Robot, support: SupportPolygon) -> None:
        self._support = support
        self._cross_over = CrossOver(robot)
        self.foot_acceleration = _SWING_ACCELERATION * foot_acceleration(robot)

    def update_swing(
        self,
        state: GaitState,
        planned: DcmReference,
        reference: Reference,
        ankles: tuple[float, float],
    ) -> tuple[DcmReference, complex]:
        """Shorten the swing if its landing place is out of reach, and choose the gait after it.

        Args:
            state: whose `gait` and `duration` it sets.
            planned: DCM and ZMP without any adjustment.
            reference: the wanted DCM for a landing place; given None, without any adjustment.
            ankles: how far the ZMP gets along the sole and across it, m.

        Returns:
            DCM and ZMP without any adjustment, in the gait and the time that were chosen, and by
            how much the landing place has to move then, in the support sole's axes, m.
        """
        quick = state.recovery_gait
        tolerance = _WITHIN_REACH[0 if state.recovering else 1]
        if not state.is_quick:
            # Not in quick steps: what moves the DCM there is mostly the motion of legs and trunk.
            ahead = dcm_ahead(state, min(_SWING_LOOKAHEAD, state.remaining))
            shift = uncaught_dcm_error(state, planned, ankles, ahead)
            least = _OUT_OF_REACH * state.gait.com_height
            if shift == 0j or self._missed(state, shift) <= least:
                return planned, shift
            if quick is state.normal_gait or state.on_stairs:
                return planned, shift
            remaining = max(quick.single_support - state.time, _LEAST_REMAINING)
            planned, shift = self._retime(state, remaining, state.duration, reference, ankles)
        else:
            state.shortened = True
            planned, shift = self._choose_gait(state, tolerance, reference, ankles)
            if state.swing_is_knocked and self._lasts_longer(state, shift, math.inf):
                planned, shift = self._choose_gait(state, tolerance, reference, ankles)
        if state.crossing != 0.0:
            if not self._cross_over.goes_on(state, self._wanted(state, shift)):
                state.crossing = 0.0
        elif self._begins_to_cross_over(state, planned, shift):
            least = self._least_time(state, shift)
            state.duration = max(state.duration, state.time + least)
            planned, shift = self._choose_gait(state, tolerance, reference, ankles)
        return planned, shift

    def update_fixed_landing(
        self,
        state: GaitState,
        swing: SwingFoot,
        reference: Reference,
        ankles: tuple[float, float],
    ) -> DcmReference | None:
        """Choose what a foot does that is about to land at a fixed place, when a push comes.

        The push tilts the robot, and the foot would wait in the air for the ground. If the DCM
        leaves towards the support foot, or the foot is just about to touch the ground, it lands, by
        time, and the other one steps; else it is on the right side already and goes farther. A foot
        that is late goes on down: the ground is lower there than was thought, so that by time it
        would land in the air.

        Args:
            state: whose `shortened`, `gait` and `duration` it sets.
            swing: reference of the foot.
            reference: see `update_swing`.
            ankles: see `update_swing`.

        Returns:
            The wanted DCM for the fixed place; None if the foot goes on to another one.
        """
        planned = reference(swing.target)
        may_step = not state.is_quick and state.recovery_gait is not state.normal_gait
        if not may_step or state.on_stairs or state.remaining == 0.0:
            return planned
        shift = uncaught_dcm_error(state, planned, ankles, dcm_ahead(state, _SWING_LOOKAHEAD))
        if abs(shift) <= _OUT_OF_REACH * state.gait.com_height:
            return planned
        leaves_inwards = -lateral_sign(state.swing_side) * shift.imag > abs(shift.real)
        if leaves_inwards or state.remaining <= _LANDS:
            state.shortened, state.gait = True, state.recovery_gait
            return reference(swing.target)
        self._retime(state, _LEAST_REMAINING, math.inf, reference, ankles)
        return None

    def reachable(self, state: GaitState, wanted: Placement) -> Placement:
        """The nearest landing place of the swing foot."""
        return self._cross_over.nearest(state, wanted)

    def _begins_to_cross_over(
        self, state: GaitState, planned: DcmReference, shift: complex
    ) -> bool:
        """Whether the swing foot crosses over to the other side of the support foot, from now on.

        A foot that has passed it can no longer: it is decided for the DCM to which the push, if it
        lasts on, will have moved it. In quick steps what moves the DCM is mostly the motion of legs
        and trunk, and the present one counts.

        Args:
            state: whose `crossing` it sets.
            planned: DCM and ZMP without any adjustment.
            shift: by how much the landing place has to move, in the support sole's axes, m.
        """
        wanted = self._wanted(state, shift)
        remaining, to_sole = state.remaining, planar_rotation(-state.stance.yaw)
        if not state.recovering:
            growth = math.exp(state.gait.omega * remaining)
            wanted += min(_LOOKAHEAD, remaining) * growth * (lasting_rate(state) * to_sole)
        resting = ZmpSegment(planned.zmp, planned.zmp, remaining)
        at_touchdown = dcm_after(resting, planned.dcm, remaining, state.gait.omega)
        offset = (at_touchdown - state.landing.point) * to_sole
        state.crossing = self._cross_over.side(state, wanted, offset.real)
        return state.crossing != 0.0

    def _retime(
        self,
        state: GaitState,
        remaining: float,
        latest: float,
        reference: Reference,
        ankles: tuple[float, float],
    ) -> tuple[DcmReference, complex]:
        """Set when the swing of a usual step ends, now that it has to catch a push.

        Args:
            state: whose `shortened`, `gait` and `duration` it sets.
            remaining: time that is left for it, s; longer if the foot takes longer.
            latest: when it ends at the latest, s.
            reference: see `update_swing`.
            ankles: see `update_swing`.

        Returns:
            See `update_swing`.
        """
        state.shortened, tolerance = True, _WITHIN_REACH[1]
        state.duration = min(latest, state.time + remaining)
        planned, shift = self._choose_gait(state, tolerance, reference, ankles)
        if self._lasts_longer(state, shift, latest):
            planned, shift = self._choose_gait(state, tolerance, reference, ankles)
        if isinstance(state.swing, SwingFoot):  # the push has just begun, and goes on
            state.swing.aim_anew()
        return planned, shift

    def _lasts_longer(self, state: GaitState, shift: complex, latest: float) -> bool:
        """Prolong the swing if its foot takes longer to the landing place, moved by `shift`.

        Args:
            state: whose `duration` it sets.
            shift: in the support sole's axes, m.
            latest: when the swing ends at the latest, s.

        Returns:
            Whether it had to be prolonged.
        """
        least = self._least_time(state, shift)
        if least <= state.remaining:
            return False
        state.duration = min(latest, state.time + least)
        return True

    def _choose_gait(
        self, state: GaitState, tolerance: float, reference: Reference, ankles: tuple[float, float]
    ) -> tuple[DcmReference, complex]:
        """Set the normal gait if the landing place in it is in reach, else the recovery gait.

        Args:
            state: whose `gait` it sets.
            tolerance: by how much the landing place may be out of reach, m.
            reference: see `update_swing`.
            ankles: see `update_swing`.

        Returns:
            See `update_swing`.
        """
        state.gait = state.normal_gait
        planned = reference(None)
        shift = uncaught_dcm_error(state, planned, ankles)
        if self._missed(state, shift) <= tolerance:
            return planned, shift
        state.gait = state.recovery_gait
        planned = reference(None)
        return planned, uncaught_dcm_error(state, planned, ankles)

    def update_transfer(
        self,
        state: GaitState,
        planned: DcmReference,
        reference: Reference,
        ankles: tuple[float, float],
    ) -> DcmReference:
        """Shorten the transfer if no ZMP within the support catches the DCM; see `update_swing`.

        The foot to which the weight moves steps instead if the other one carries the robot better.
        While both feet together catch the DCM, the transfer is prolonged instead; so is that of a
        quick step.

        Args:
            state: whose `gait`, `duration` and `requested_swing` it sets.
            planned: DCM and ZMP without any adjustment.
            reference: see `update_swing`.
            ankles: see `update_swing`.
        """
        quick, state.requested_swing = state.recovery_gait, None
        if state.recovering and not state.starting:
            return self._update_recovery_transfer(state, planned, reference, ankles)
        if quick is state.gait or abs(state.dcm - planned.dcm) <= _LEAST_ERROR or state.on_stairs:
            return planned
        # The ZMP moves on to the support foot: half the way is its mean.
        reach = self._zmp_range(state, planned, 0.5)
        if uncaught_dcm_error(state, planned, reach) == 0j:
            return planned
        error = (state.dcm - planned.dcm) * planar_rotation(-state.stance.yaw)
        if not state.starting and self._both_feet_catch(state, error):
            if state.remaining <= _HOLD:
                state.duration = state.time + _HOLD
            return planned
        if not state.starting and has_to_return(state, self._support):
            state.requested_swing = state.support
        state.gait, state.shortened = quick, True
        state.duration = min(state.duration, max(quick.double_support, state.time))
        return reference(None)

    def _update_recovery_transfer(
        self,
        state: GaitState,
        planned: DcmReference,
        reference: Reference,
        ankles: tuple[float, float],
    ) -> DcmReference:
        """Choose at the end of a quick transfer what follows; see `update_transfer`.

        If the ankles alone catch the DCM in a step of the normal gait, that is the next one. Else,
        if the DCM is not beyond the support sole, the robot stays on both feet until they do: a
        foot that comes back from a wide step moves the pivot towards itself by `κ a` (see
        `SwingMomentum`), which drives the DCM away by more than a quick step with the ZMP at the
        sole's edge takes back.
        """
        if state.remaining > _HOLD:
            return planned
        quick = state.gait
        state.gait = normal = state.normal_gait
        held = reference(None)
        error = (state.dcm - held.dcm) * planar_rotation(-state.stance.yaw)
        if footstep_adjustment(error, normal.omega, normal.single_support, ankles) == 0j:
            return held
        state.gait = quick
        if not self._both_feet_catch(state, error):
            return planned
        state.duration = state.time + _HOLD
        return held

    def _both_feet_catch(self, state: GaitState, error: complex) -> bool:
        """Whether a DCM on its way from one foot to the other is not beyond the support sole.

        The other foot carries little at the end of a transfer: the ZMP is on the support sole.

        Args:
            state: during a transfer between steps.
            error: of the DCM, in the support sole's axes, m.
        """
        if state.time > _LONGEST_HOLD:
            return False
        dcm, inside = state.stance.to_local(state.dcm), _INSIDE * state.normal_gait.com_height
        along, across = self._support.zmp_range(state.support, 1.0)
        return (
            math.copysign(dcm.real, dcm.real * error.real) <= along - inside
            and math.copysign(dcm.imag, dcm.imag * error.imag) <= across
        )

    def update_standing(self, state: GaitState, planned: DcmReference) -> None:
        """Request a step if the DCM is near the edge of the support; see `update_swing`."""
        state.gait, state.requested_swing = state.normal_gait, None
        if state.recovery_gait is state.gait or state.on_stairs:
            return
        if state.lost_foot is not None:
            state.requested_swing, state.gait = state.lost_foot, state.recovery_gait
            return
        lifted = state.lifted is not None
        # A motion may bring the planned ZMP itself to the edge: small errors are the ankles'. On
        # one leg, where the sole's edge is as near, those that the ankle can still catch are.
        least, share = (0.0, _USED_SOLE) if lifted else (_LEAST_ERROR, _USED_SUPPORT)
        dcm = state.dcm if lifted else dcm_ahead(state, _LOOKAHEAD)
        if abs(dcm - planned.dcm) <= least:
            return
        error = (dcm - planned.dcm) * planar_rotation(-state.stance.yaw)
        along, across = self._zmp_range(state, planned, 1.0)
        if abs(error.real) < share * along and abs(error.imag) < share * across:
            return
        if lifted:
            state.requested_swing = state.swing_side
        else:
            state.requested_swing = first_swing(state, dcm, error.imag, self._support)
        state.gait = state.recovery_gait

    def _least_time(self, state: GaitState, shift: complex) -> float:
        """Time in which the swing foot gets to the landing place, moved by `shift`, s."""
        if not isinstance(state.swing, SwingFoot):
            return 0.0
        reachable = self._reachable(state, self._moved(state, shift))
        return state.swing.time_to(reachable, self.foot_acceleration)

    def _missed(self, state: GaitState, shift: complex) -> float:
        """How far the landing place, moved by `shift`, is out of the leg's reach, m."""
        wanted = self._moved(state, shift)
        return abs(self._reachable(state, wanted) - wanted)

    def _wanted(self, state: GaitState, shift: complex) -> complex:
        """The landing place, moved by `shift`, in the support sole's axes, m."""
        return state.stance.to_local(self._moved(state, shift))

    def _moved(self, state: GaitState, shift: complex) -> complex:
        return state.landing.point + shift * planar_rotation(state.stance.yaw)

    def _reachable(self, state: GaitState, point: complex) -> complex:
        """The nearest ground point at which the swing foot can land, m."""
        wanted = Placement(point, state.landing.yaw, state.landing.height)
        return self.reachable(state, wanted).point

    def _zmp_range(
        self, state: GaitState, planned: DcmReference, share: float
    ) -> tuple[float, float]:
        """How far the ZMP gets along and across the support sole, towards the DCM error, m.

        Args:
            state: of the gait.
            planned: DCM and ZMP.
            share: of the way from the support foot to the planned ZMP from which it starts.
        """
        stance = state.stance
        error = (state.dcm - planned.dcm) * planar_rotation(-stance.yaw)
        zmp = share * stance.to_local(planned.zmp)
        along, across = math.copysign(1.0, error.real), math.copysign(1.0, error.imag)
        corners = [stance.to_local(corner) - zmp for corner in self._support.corners(state)]
        return max(along * c.real for c in corners), max(across * c.imag for c in corners)
