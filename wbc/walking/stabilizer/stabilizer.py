"""Stabilizer: turns the measured DCM into a ZMP, a CoM acceleration and a landing place."""

from __future__ import annotations

from dataclasses import dataclass

from wbc.gait import SWING, DcmReference, GaitState, Hop, Placement, SwingFoot
from wbc.geometry.planar import planar_rotation
from wbc.robot import Robot
from wbc.walking.feet import GroundReaction
from wbc.walking.gains import WalkerGains
from wbc.walking.ground_kinematics import CentroidalMotion
from wbc.walking.stabilizer.com_bias import ComBiasEstimator
from wbc.walking.stabilizer.dcm_feedback import zmp_from_dcm_error
from wbc.walking.stabilizer.disturbance import DisturbanceObserver, is_pushed
from wbc.walking.stabilizer.hopping import Hopping
from wbc.walking.stabilizer.push_recovery import PushRecovery, Reference
from wbc.walking.stabilizer.support_polygon import SupportPolygon
from wbc.walking.stabilizer.tipping import edge_to_tip_over


@dataclass(slots=True)
class StabilizerOutput:
    """The output of the stabilizer at this tick; ground points in world axes.

    Attributes:
        dcm: estimated DCM without the bias of the CoM, m; of a walking robot that is pushed, with
            what its angular momentum adds.
        reference: DCM and ZMP that the planner wants, for the landing place below.
        zmp: commanded ZMP, clamped to the support, m.
        com_acceleration: horizontal acceleration of the CoM that realises it, m/s².
        landing: placement at which the swing foot is to land.
    """

    dcm: complex
    reference: DcmReference
    zmp: complex
    com_acceleration: complex
    landing: Placement


class Stabilizer:
    """Keeps the divergent component of motion on its reference.

    At every tick:

    1. the bias of the estimated CoM is taken off the DCM (`ComBiasEstimator`), and of a walking
       robot that is pushed the angular momentum is added to it (`observe`);
    2. the landing place moves by what the ankles cannot catch (`footstep_adjustment`), and
       the step is quickened when no landing place in reach does (`PushRecovery`);
    3. a support foot whose edge the DCM has left tips over it (`edge_to_tip_over`);
    4. the DCM error becomes a ZMP (`zmp_from_dcm_error`), clamped to the support
       (`SupportPolygon`) and realised by the CoM acceleration `c̈ = ω² (c − p − δ)` of the linear
       inverted pendulum on the centroidal moment pivot p + δ.

    Args:
        robot: the robot.
        gains: margins of the ZMP and share of the sole that the ankles use.
        dt: control period, s.

    Attributes:
        com_bias: estimates the bias of the CoM.
        support: the support polygon.
        push_recovery: quick steps after a push.
    """

    def __init__(self, robot: Robot, gains: WalkerGains, dt: float) -> None:
        self._gains = gains
        self.com_bias = ComBiasEstimator(robot.gravity, dt)
        self.support = support = SupportPolygon(robot)
        # Per side, how far the ankles move the ZMP along and across the sole, m.
        self._ankles: dict[str, tuple[float, float]] = {
            sole.side: support.zmp_range(sole.side, gains.ankle_share) for sole in robot.soles
        }
        self.push_recovery = PushRecovery(robot, self.support)
        self._hopping = Hopping(robot, self.support, self.push_recovery.foot_acceleration)
        self._disturbance = DisturbanceObserver(dt)
        self._dcm_of_com = self._momentum = 0j  # m; the DCM without angular momentum, and its part

    def reset(self) -> None:
        """Start anew, at rest and without a known bias."""
        self.com_bias.reset()
        self.resume()

    def resume(self) -> None:
        """Go on after another controller, with the bias known so far."""
        self._disturbance.reset()
        self._hopping.reset()

    def observe(
        self,
        state: GaitState,
        com: CentroidalMotion,
        reaction: GroundReaction | None,
        heading: float,
        hand_offset: complex = 0j,
    ) -> None:
        """Write CoM, its vertical velocity, DCM and disturbance of this tick into the gait's state.

        A push off the centre of mass also turns the robot. To stop the turning takes a moment of
        the ground, which drives the centre of mass on: an angular momentum L, brought to zero at
        once, moves the DCM by

            ω (L_y, −L_x) / (m g).

        No motion of trunk and limbs changes the angular momentum about the foot that this DCM
        stands for (Gong and Grizzle, Zero dynamics, pendulum models, and angular momentum in
        feedback control of bipedal locomotion, ASME JDSMC 2022). It is counted from the moment on
        in which a push is seen, and in quick steps; undisturbed, the swing leg has the only
        momentum, and the plan knows it. It is not counted of a robot that was pushed while it
        stood: its trunk takes the momentum up, and what it gives back when it rights itself is
        nothing to step for.

        Args:
            state: state of the gait.
            com: estimated motion of the centre of mass.
            reaction: measured force of the ground on a robot at rest; else None.
            heading: heading of the robot, rad.
            hand_offset: by how much known forces on the hands move the pivot off the ZMP, m.
        """
        omega = state.gait.omega
        dcm = com.point + com.velocity / omega
        state.com, state.com_height = com.point, com.height
        state.com_velocity, state.vertical_velocity = com.velocity, com.vertical_velocity
        self._dcm_of_com = dcm - self.com_bias.update(com, reaction, heading, hand_offset)
        self._momentum = omega * com.centroidal_momentum
        state.disturbance = self._disturbance.update(com.velocity, omega)
        counts = is_pushed(state) and not (state.pushed_at_rest or state.at_rest)
        state.dcm = self._dcm_of_com + (self._momentum if counts else 0j)

    def update(self, state: GaitState, reference: Reference) -> StabilizerOutput:
        """Decide on ZMP, CoM acceleration and landing place of this tick.

        Args:
            state: phase, feet, planned landing place, CoM and DCM.
            reference: the wanted DCM for a landing place of the swing foot, or, given None,
                for the planned one.
        """
        if state.hop is not None:
            return self._hop(state, state.hop)
        wanted, landing = self._adjust_steps(state, reference)
        gait, dcm = state.gait, state.dcm
        omega = gait.omega
        zmp = zmp_from_dcm_error(dcm, wanted, omega, gait.dcm_gain)
        if state.tipping == 0j:
            state.tipping = edge_to_tip_over(state, zmp, self.support, self._gains.tipping_distance)
        zmp = self.support.clamp(zmp, state, self._gains.zmp_margin)
        # The CoM as estimated, with its bias: the QP uses the same, so the ZMP is as commanded.
        acceleration = omega * omega * (state.com - zmp - wanted.cmp_offset)
        # The disturbance is seen in the velocity of the CoM, which has no part of the momentum.
        self._disturbance.expect(omega * (self._dcm_of_com - zmp - wanted.cmp_offset))
        return StabilizerOutput(dcm, wanted, zmp, acceleration, landing)

    def has_to_hop(self, state: GaitState, contacts: frozenset[str] | None, tilt: float) -> bool:
        """Return whether the support foot has to hop from now on, to catch a push.

        Args:
            state: phase, feet, CoM and DCM.
            contacts: sides of the soles that touch the ground; None when it is not measured.
            tilt: angle of the body from the vertical, rad.
        """
        if self._gains.hop_speed == 0.0:
            return False
        return self._hopping.begins(state, contacts, tilt, self._dcm_of_com, self._momentum)

    def _hop(self, state: GaitState, hop: Hop) -> StabilizerOutput:
        """ZMP and CoM acceleration of the thrust, and both landing places.

        The ZMP is where the sole is nearest to the DCM. In the thrust the ground presses by `g + a`
        on each kilogram: c̈ = (g + a)/z (c − p).
        """
        hopping = self._hopping
        zmp, acceleration = self.support.clamp(state.dcm, state, 0.0), 0j
        if not hop.flies:
            height = state.com_height - state.stance.height
            pressure = state.gait.gravity + hop.vertical_acceleration
            acceleration = pressure / height * (state.com - zmp)
        hop.landing = hopping.landing(state, hop)
        self._disturbance.expect(state.com_velocity + acceleration / state.gait.omega)
        reference = DcmReference(state.dcm, 0j, zmp)
        return StabilizerOutput(state.dcm, reference, zmp, acceleration, hopping.away(state, hop))

    def _adjust_steps(
        self, state: GaitState, reference: Reference
    ) -> tuple[DcmReference, Placement]:
        """Wanted DCM and landing place; moves and shortens steps that do not catch the DCM."""
        swing, recovery = state.swing, self.push_recovery
        if state.may_choose_side:
            planned = reference(None)
            recovery.update_standing(state, planned)
            return planned, state.landing
        ankles = self._ankles[state.support]
        if state.phase is SWING and isinstance(swing, SwingFoot):
            if swing.target_frozen:
                fixed = recovery.update_fixed_landing(state, swing, reference, ankles)
                if fixed is not None:
                    return fixed, swing.target
            return self._adjust_swing(state, reference, ankles)
        return recovery.update_transfer(state, reference(None), reference, ankles), state.landing

    def _adjust_swing(
        self, state: GaitState, reference: Reference, ankles: tuple[float, float]
    ) -> tuple[DcmReference, Placement]:
        """Wanted DCM and landing place, moved when the ankles alone cannot catch the DCM."""
        recovery = self.push_recovery
        planned, shift = recovery.update_swing(state, reference(None), reference, ankles)
        if shift == 0j and not state.shortened:
            return planned, state.landing
        landing, stance = state.landing, state.stance
        point = landing.point + shift * planar_rotation(stance.yaw)
        moved = recovery.reachable(state, Placement(point, landing.yaw, landing.height))
        if state.ground_slope != 0j:
            moved = state.on_slope(moved)
        return reference(moved), moved
