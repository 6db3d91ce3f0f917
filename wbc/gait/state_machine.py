"""State machine of the gait: which feet stand, which swings, and when this changes."""

from __future__ import annotations

import math

from wbc.errors import GaitError
from wbc.gait.footsteps import other_side
from wbc.gait.hop import Hop
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.lost_contact import LostContact
from wbc.gait.parameters import GaitParameters
from wbc.gait.phase import STAND, SWING, TRANSFER, Phase
from wbc.gait.planners.planner import Planner
from wbc.gait.speed_adaptation import SpeedAdaptation
from wbc.gait.state import GaitCommand, GaitState, PlannedFootstep
from wbc.gait.swing_foot import SwingFoot, lift_share
from wbc.geometry.planar import Feet, Placement

_STAIR = 0.05  # m; footholds whose heights differ by more are on stairs
_SHORTENING = 0.5  # share of the double support that a late touchdown may take off it
_MOVED = 0.03  # m from its planned place at which the last step is followed by another one
_FROM_THE_AIR = 0.7  # share of the single support after which a foot that was held up lands
_FIRST_TRANSFER = 0.2  # share of the transfer out of standing before a step that catches a push
_HIGH = 0.04  # m over its landing place from which on the end of a quick step waits for the foot
_LONGEST_WAIT = 0.06  # s, the same
_AFTER_HOP = 0.14  # s after a hop in which the swing foot lands
_FLIGHT = 0.25  # s that the flight is taken for in the thrust: a leg in a hurry takes from it
_EARLIEST_TOUCHDOWN = 0.6  # share of the swing before which contact is lift-off noise


class GaitStateMachine:
    """Runs the phases of the gait: stand → transfer → swing → transfer → … → stand.

    Time drives it, except that a swing ends with contact: early when the foot meets the ground
    before its time, late when it keeps descending until it does. During a swing the support foot
    may hop (`hop`). Which foot swings next, where and when it lands, and the DCM are the planner's.

    A tick has two halves: `update` moves on to the phase of now, then `move_swing` moves the
    swing foot towards the landing place that the stabilizer decided on in the same tick.

    Args:
        gait: parameters of the gait.
        feet: both soles, on the ground.
        planner: plans footsteps and DCM.
        recovery_gait: parameters of the quick steps after a push; `gait` when left out.
        adaptation: adapts the parameters to the speed, from `gait` on; when left out, they are the
            same at every speed.

    Attributes:
        state: phase, feet and times of now.
        step_length: length of the present steps, m; 0 while standing.
    """

    def __init__(
        self,
        gait: GaitParameters,
        feet: Feet,
        planner: Planner,
        recovery_gait: GaitParameters | None = None,
        adaptation: SpeedAdaptation | None = None,
    ) -> None:
        self._adaptation = adaptation
        self._since_touchdown = 0.0  # s
        self.state = GaitState(gait, feet, recovery_gait or gait)
        self.step_length = 0.0
        self._planner = planner
        self._planned_landing: Placement | None = None
        self._lost_contact = LostContact(feet)
        planner.reset(self.state)

    def update(
        self, dt: float, feet: Feet, command: GaitCommand, contacts: frozenset[str] | None
    ) -> None:
        """Move on by dt to the phase of now.

        Args:
            dt: time since the last tick, s.
            feet: soles as estimated.
            command: wanted velocity or given footsteps.
            contacts: sides of the soles that touch the ground; None when it is not measured:
                then a swing ends at its planned time.
        """
        state, planner, adaptation = self.state, self._planner, self._adaptation
        if adaptation is not None:
            # The first step out of standing is not faster than the usual ones.
            walking = not (state.phase is STAND or state.starting)
            velocity = adaptation.ramp(command.velocity, dt, walking=walking)
            state.fast_share = adaptation.fast_share(velocity)
            if velocity is not command.velocity:
                command = GaitCommand(velocity, command.footsteps)
        lifted = state.lifted
        state.feet = feet
        state.time += dt
        self._since_touchdown += dt
        if state.hop is not None and not self._lands(state.hop, contacts, dt):
            return
        given = command.footsteps
        if given or state.on_stairs or state.at_rest:
            state.on_stairs = _leads_over_stairs(state, lifted, given, contacts)
        state.lost_foot = self._lost_contact.update(state, contacts, dt)
        asked = state.requested_swing if state.may_choose_side else None
        if given and asked == state.support:
            asked = None  # the first of the given footsteps is the other foot's
        if state.phase is STAND or (asked and state.phase is TRANSFER):
            side = planner.next_swing(state, command) if state.phase is STAND else None
            if asked and not (side and command.footsteps):
                side = asked
            if side is not None:
                self._adapt_to_speed(command)
                state.support = other_side(side)
                state.starting, state.stopping = True, False
                state.pushed_at_rest = state.requested_swing is not None
                share = _FIRST_TRANSFER if state.pushed_at_rest else 1.0
                self._enter(TRANSFER, share * state.gait.first_transfer)
        elif state.phase is TRANSFER:
            if state.lost_foot is not None and not state.starting:
                self._swing_from_the_air(state.lost_foot)
            elif state.requested_swing == state.support and not command.footsteps:
                # The weight goes back to the foot that it comes from.
                state.support, state.requested_swing = state.swing_side, None
                self._enter(TRANSFER, state.recovery_gait.double_support)
            elif state.time >= state.duration:
                if state.stopping:
                    self._enter(STAND, 0.0)
                else:
                    self._enter(SWING, state.gait.single_support)
        elif lifted is not None:
            lifted.follow_support(state.stance)
            if self._is_set_down(lifted, contacts):
                state.swing = None
                self._enter(STAND, 0.0)
            elif state.requested_swing is not None:
                state.swing = None
                self._enter(SWING, _FROM_THE_AIR * state.gait.single_support)
                state.shortened = True
        elif state.lost_foot is not None:
            if state.swing_side in (contacts or ()):
                state.steps += 1
            self._swing_from_the_air(state.lost_foot)
        elif self._has_landed(contacts):
            self._touch_down(command)
        plan = planner.update(state, command, dt)
        self.step_length = plan.step_length
        if plan.duration is not None:
            state.duration = plan.duration
        self._planned_landing = plan.landing
        if state.phase is SWING and plan.landing is not None:
            state.landing = plan.landing
            if state.swing is None:
                self._lift_off(plan.landing, lifted)

    def move_swing(self, dt: float, landing: Placement) -> None:
        """Move the swing foot's reference on by dt towards a landing place."""
        state = self.state
        state.landing = landing
        if state.hop is not None:
            state.hop.advance(dt)
        if isinstance(state.swing, SwingFoot) and state.time > 0.0:
            state.swing.duration = state.duration
            state.swing.advance(dt, landing, state.ground_slope)

    def hop(self, take_off_speed: float) -> None:
        """Hop with the support foot from now on, to catch a push; the swing goes on meanwhile.

        Args:
            take_off_speed: see `Hop`.
        """
        state = self.state
        state.hop = Hop(state, take_off_speed)
        state.shortened, state.gait, state.tipping = True, state.recovery_gait, 0j

    def _lands(self, hop: Hop, contacts: frozenset[str] | None, dt: float) -> bool:
        """Go on with a hop; return whether it lands: then the swing goes on as usual."""
        state = self.state
        landed = hop.update(state, contacts, dt)
        state.duration = state.time + _AFTER_HOP
        if not landed:
            state.duration += hop.remaining if hop.flies else _FLIGHT
        else:
            state.hop = None
            self._lost_contact.stand_anew(state.support, state.feet)
            if isinstance(state.swing, SwingFoot):
                state.swing.aim_anew()
        return landed

    def change_gait(self, gait: GaitParameters, recovery_gait: GaitParameters) -> None:
        """Go on with other parameters; the present phase keeps its duration.

        Args:
            gait: parameters of the gait, at usual speeds.
            recovery_gait: parameters of the quick steps after a push; `gait` for none.
        """
        state, recovering = self.state, self.state.recovering
        normal = gait if self._adaptation is None else self._adaptation.change_gait(gait)
        state.normal_gait = normal
        state.recovery_gait = normal if recovery_gait is gait else recovery_gait
        state.gait = state.recovery_gait if recovering else normal
        if isinstance(state.swing, SwingFoot):
            state.swing.set_apex(gait.swing_height)

    def stand_on(self, side: str) -> None:
        """While standing: which foot the ground holds exactly, and is not to be lifted.

        Raises:
            GaitError: the robot is not standing.
        """
        self._must_stand(f"stand_on('{side}')")
        self.state.support = side

    def lift(self) -> LiftedFoot:
        """Stand on the support foot alone from now on; returns the other one's reference.

        The weight has to be over the support foot already (`weight_shift`), the other one
        unloaded (`other_foot_load`). It ends when the foot is lowered with `expects_contact`
        set and touches the ground, or when a step is requested (`requested_swing`) that catches
        a push.

        Raises:
            GaitError: the robot is not standing.
        """
        self._must_stand("lift()")
        state = self.state
        lifted = LiftedFoot(state.other_foot, state.stance)
        self._enter(SWING, math.inf)
        state.swing = lifted
        return lifted

    def _must_stand(self, call: str) -> None:
        if self.state.phase is not STAND:
            raise GaitError(f"{call} in phase {self.state.phase.name}: only while standing")

    def _enter(self, phase: Phase, duration: float) -> None:
        state = self.state
        state.phase, state.time, state.duration, state.hold = phase, 0.0, duration, 0.0
        state.shortened, state.crossing, state.tipping = False, 0.0, 0j
        self._lost_contact.begin_phase(state.feet)

    def _swing_from_the_air(self, side: str) -> None:
        """Step with a foot that was knocked off the ground; the other one carries the robot."""
        state = self.state
        state.support, state.gait = other_side(side), state.recovery_gait
        state.stopping, state.requested_swing, state.swing = False, None, None
        self._enter(SWING, state.gait.single_support)
        state.shortened = True

    def _lift_off(self, landing: Placement, lifted: LiftedFoot | None) -> None:
        """Begin the swing to a landing place; a foot that was held up begins it where it is."""
        state = self.state
        gait, start = state.gait, state.other_foot if lifted is None else lifted.target
        airborne = state.lost_foot == state.swing_side
        swing = SwingFoot(
            start._replace(height=landing.height) if airborne else start,
            landing,
            state.duration,
            gait.swing_height,
            gait.touchdown_speed,
            state.lift_off_slope,
            lift_share(state.fast_share),
        )
        if lifted is not None:
            swing.start_from(lifted.motion, lifted.yaw)
        elif airborne:
            swing.start_at(start.height)
        state.swing = swing

    def _adapt_to_speed(self, command: GaitCommand) -> None:
        """Choose the normal gait of the steps from now on."""
        if self._adaptation is None or command.footsteps:
            return
        state, normal = self.state, self._adaptation.at(command.velocity)
        if state.gait is state.normal_gait:
            state.gait = normal
        if state.recovery_gait is state.normal_gait:  # no quick steps after a push
            state.recovery_gait = normal
        state.normal_gait = normal

    def _is_set_down(self, foot: LiftedFoot, contacts: frozenset[str] | None) -> bool:
        if contacts is None:
            return foot.overdue
        return foot.expects_contact and self.state.swing_side in contacts

    def _has_landed(self, contacts: frozenset[str] | None) -> bool:
        state = self.state
        if contacts is None:
            return state.time >= state.duration
        if state.shortened:
            # A quick foot is low and may scuff; one that is late costs more than one that is
            # pressed down, because the DCM runs away. But while it is high, the robot would have
            # no foot on the ground instead of the one that still stands.
            late = state.time - state.duration
            high = state.other_foot.height - state.landing.height > _HIGH
            waits = high and late < _LONGEST_WAIT and contacts == {state.support}
            return late >= 0.0 and not waits
        return state.swing_side in contacts and state.progress >= _EARLIEST_TOUCHDOWN

    def _was_moved(self) -> bool:
        """Whether a push moved the landing place, which asks for another step."""
        state, planned = self.state, self._planned_landing
        if planned is None or state.on_stairs:  # where another foothold may be an edge
            return False
        return abs(state.landing.point - planned.point) > _MOVED

    def _touch_down(self, command: GaitCommand) -> None:
        state = self.state
        state.steps += 1
        if self._adaptation is not None and not (state.starting or state.shortened):
            length = state.stance.to_local(state.other_foot.point).real
            self._adaptation.observe_step(length, self._since_touchdown)
        self._since_touchdown = 0.0
        state.pushed_at_rest = state.steps_out
        side = self._planner.next_swing(state, command)
        self._adapt_to_speed(command)
        if side is None and (state.shortened or self._was_moved()):
            side = state.support  # after a push it comes to rest in a usual step, its feet square
        state.swing = None
        state.starting, state.stopping = False, side is None
        if side is None:
            self._enter(TRANSFER, state.gait.first_transfer)
            return
        state.support = other_side(side)
        # The weight keeps its time: after an early touchdown it stays where it is for a
        # while, after a late one it moves faster. The DCM is where it was to be.
        usual = state.gait.double_support
        spare = max(-_SHORTENING * usual, state.duration - state.time)
        self._enter(TRANSFER, usual + spare)
        state.hold = max(spare, 0.0)


def _leads_over_stairs(
    state: GaitState,
    lifted: LiftedFoot | None,
    given: list[PlannedFootstep],
    contacts: frozenset[str] | None,
) -> bool:
    """Whether the footholds of now and those given differ much in height.

    Those of a robot that walks without given ones are no stairs, but of a slope: there a long quick
    step is as high.
    """
    present = state.stance.height
    swings = state.phase is SWING
    standing = {state.support} if swings else {"left", "right"}
    if contacts is not None and not standing <= contacts:
        return state.on_stairs  # a foot that was knocked up is on no stair
    if any(abs(step.placement.height - present) > _STAIR for step in given):
        return True
    if swings:
        other = state.landing.height if lifted is None else present
    else:
        other = state.other_foot.height
    return abs(other - present) > _STAIR and (state.on_stairs or state.at_rest)
