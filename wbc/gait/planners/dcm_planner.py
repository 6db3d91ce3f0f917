"""Analytic DCM planner: footsteps at a velocity, and the DCM that leads over them to rest."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.gait.footsteps import Velocity, first_swing_side
from wbc.gait.phase import STAND, SWING, TRANSFER
from wbc.gait.planners.dcm import DcmReference, ZmpSegment, dcm_before, solve_dcm
from wbc.gait.planners.footstep_preview import FootstepPreview, zmp_over
from wbc.gait.planners.planner import StepPlan
from wbc.gait.state import GaitCommand, GaitState, PlannedFootstep
from wbc.gait.velocity_filter import VelocityFilter
from wbc.geometry.planar import Placement

PREVIEW_STEPS = 3  # later steps change the present DCM by less than e^(-3ωT) < 0.1 %


_ORIGIN = Placement(0j, 0.0)


class DcmPlanner:
    """Plans with the linear inverted pendulum, in closed form, anew at every tick.

    The ZMP rests on the support foot during a swing, moves on to the next foot during double
    support, and comes to rest between the feet after the last previewed step; the DCM is
    solved backward from there (see `wbc.gait.planners.dcm`). Another velocity takes effect
    within the step; the landing place is fixed relative to the support foot as estimated.

    Attributes:
        velocity: velocity with which the present step is planned.
    """

    _preview: FootstepPreview

    def __init__(self) -> None:
        self.velocity = Velocity()
        self._filter = VelocityFilter()
        self._plan = StepPlan()
        self._relative_landing = _ORIGIN  # in the support sole's axes
        self._relative_dcm: complex | None = None  # that of the touchdown there, once computed
        self._goes_on = False  # with which it was computed: further steps follow in any case
        self._follows_given = False  # the present swing goes to a given footstep
        self._dcm_drift = 0j  # m/s, of the planned DCM while the velocity changes

    def reset(self, state: GaitState) -> None:
        """See `Planner.reset`."""
        self.velocity = Velocity()
        self._filter.reset()
        self._follows_given = False
        self._dcm_drift = 0j
        self._preview = FootstepPreview(state.gait, [])

    def next_swing(self, state: GaitState, command: GaitCommand) -> str | None:
        """See `Planner.next_swing`."""
        given, wanted = command.footsteps, command.velocity
        preview = self._current_preview(state, given)
        if state.phase is STAND:
            if not given and wanted.is_zero:
                return None
            self.velocity = wanted
            return given[0].side if given else first_swing_side(state.feet, wanted)
        # A step that was planned as the last one is: the DCM is on its way to rest, and a
        # command to go on that came too late for it waits until the robot stands.
        stance = state.stance
        last = preview.ends(stance, state.swing_side, state.landing, self.velocity)
        ended = not given and wanted.is_zero and self.velocity.is_zero
        self.velocity = wanted
        self._filter.reset()
        self._follows_given = False
        return None if last or ended else state.support

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """See `Planner.update`."""
        self._dcm_drift = 0j
        plan, given = self._plan, command.footsteps
        preview = self._current_preview(state, given)
        plan.landing = None
        if state.at_rest:
            plan.step_length = 0.0
            return plan
        stance = state.stance
        if state.phase is SWING and state.time == 0.0:
            landing = preview.next(stance, state.swing_side, self.velocity)
            self._relative_landing = landing.relative_to(stance)
            self._relative_dcm = None
            self._follows_given = bool(given)
            if given:
                given.pop(0)
        elif state.time > 0.0 and not state.stopping:
            self._follow(state, command.velocity, dt)
        velocity = self.velocity
        plan.step_length = velocity.speed * state.gait.step_duration
        if state.phase is SWING:
            plan.landing = stance.compose(self._relative_landing)
            if not self._follows_given:
                plan.landing = state.on_slope(plan.landing)
        return plan

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """See `Planner.reference`."""
        omega = state.gait.omega
        preview = self._current_preview(state, self._preview.given)
        if state.at_rest:
            zmp = dcm = state.standing_point
        elif state.phase is SWING:
            zmp = state.stance.point
            dcm = dcm_before(zmp, zmp, state.remaining, self._touchdown_dcm(state, landing), omega)
        else:
            final = None
            if not state.stopping:
                final = preview.arrival_dcm(
                    state.stance, state.support, self.velocity, PREVIEW_STEPS
                )
            dcm, _, zmp, _ = solve_dcm(self._present_zmp(state), omega, final)
        return DcmReference(dcm, omega * (dcm - zmp) + self._dcm_drift, zmp)

    def footsteps(self, state: GaitState) -> list[PlannedFootstep]:
        """See `Planner.footsteps`."""
        if state.at_rest or state.stopping:
            return []
        preview = self._preview
        stance = state.stance
        if state.phase is TRANSFER:
            return preview.steps(stance, state.support, self.velocity, PREVIEW_STEPS)
        first = PlannedFootstep(state.swing_side, state.landing)
        if preview.ends(stance, first.side, first.placement, self.velocity):
            return [first]
        further = preview.steps(first.placement, first.side, self.velocity, PREVIEW_STEPS - 1)
        return [first, *further]

    def _current_preview(
        self, state: GaitState, given: Sequence[PlannedFootstep]
    ) -> FootstepPreview:
        preview = self._preview
        if preview.gait is not state.gait or preview.given is not given:
            preview = self._preview = FootstepPreview(state.gait, given)
            self._relative_dcm = None
        return preview

    def _follow(self, state: GaitState, wanted: Velocity, dt: float) -> None:
        """Go over to another velocity within the step; landing place and DCM move along.

        Slower the less time is left until the foot lands, for the sole's own ZMP has to move the
        DCM. Not in the last step, which is planned to come to rest; and none becomes the last
        one: that is for the next.
        """
        preview = self._preview
        if self.velocity is wanted or self.velocity == wanted or self.velocity.is_zero:
            return
        if preview.given or self._follows_given:
            return
        share = state.remaining / state.duration if state.phase is SWING else 1.0
        velocity = self._filter.update(self.velocity, wanted, share, dt, state.gait)
        if velocity.is_zero or velocity == self.velocity:
            return
        before = self.reference(state).dcm
        self.velocity = velocity
        self._relative_dcm = None
        if state.swing is not None and not state.swing.target_frozen:
            stance = state.stance
            landing = preview.next(stance, state.swing_side, velocity)
            self._relative_landing = landing.relative_to(stance)
        self._dcm_drift = (self.reference(state).dcm - before) / dt

    def _touchdown_dcm(self, state: GaitState, landing: Placement | None) -> complex:
        """DCM at touchdown; the ZMP then moves from the support foot to where the foot landed.

        Args:
            state: feet and support.
            landing: placement at which the swing foot lands; None: as planned. Seen from the
                support foot the planned one is always the same, unless given footsteps, which are
                fixed in the world, come after it.
        """
        stance, side = state.stance, state.swing_side
        if landing is None and not self._preview.given:
            if self._relative_dcm is None or self._goes_on is not state.shortened:
                self._goes_on = state.shortened
                self._relative_dcm = self._leaving_dcm(
                    _ORIGIN, side, self._relative_landing, state.shortened
                )
            return stance.to_world(self._relative_dcm)
        if landing is None:
            landing = stance.compose(self._relative_landing)
        return self._leaving_dcm(stance, side, landing, state.shortened)

    def _leaving_dcm(
        self, stance: Placement, side: str, landing: Placement, goes_on: bool
    ) -> complex:
        """DCM with which the weight leaves `stance` for the foot of a side that has landed."""
        preview, support = self._preview, stance.point
        gait, omega = preview.gait, preview.gait.omega
        if not goes_on and preview.ends(stance, side, landing, self.velocity):
            rest = 0.5 * (support + landing.point)
            return dcm_before(support, rest, gait.first_transfer, rest, omega)
        arrival = preview.arrival_dcm(landing, side, self.velocity, PREVIEW_STEPS - 1)
        return dcm_before(support, landing.point, gait.double_support, arrival, omega)

    def _present_zmp(self, state: GaitState) -> list[ZmpSegment]:
        """ZMP from now to the end of the phase of a robot that steps."""
        support = state.stance.point
        if state.phase is SWING:
            return [ZmpSegment(support, support, state.remaining)]
        if state.stopping:
            origin, goal = support, state.feet.middle
        else:
            origin, goal = state.feet.middle if state.starting else state.other_foot.point, support
        zmp = origin + (goal - origin) * state.progress
        hold = max(state.hold - state.time, 0.0)
        moving = ZmpSegment(zmp, goal, state.remaining - hold)
        return [ZmpSegment(zmp, zmp, hold), moving] if hold > 0.0 else [moving]

    def _later_zmp(self, state: GaitState, stance: Placement) -> list[ZmpSegment]:
        """ZMP after the present phase of a robot that steps and does not come to rest in it.

        Args:
            state: phase and support.
            stance: placement of the support sole; with given footsteps that in the world.
        """
        preview, support, side = self._preview, stance.point, state.swing_side
        gait, velocity = preview.gait, self.velocity
        if state.phase is TRANSFER:
            steps = preview.steps(stance, state.support, velocity, PREVIEW_STEPS)
            return zmp_over(support, [step.placement.point for step in steps], gait)
        landing = stance.compose(self._relative_landing)
        point = landing.point
        if not state.shortened and preview.ends(stance, side, landing, velocity):
            return [ZmpSegment(support, 0.5 * (support + point), gait.first_transfer)]
        steps = preview.steps(landing, side, velocity, PREVIEW_STEPS - 1)
        later = zmp_over(point, [step.placement.point for step in steps], gait)
        return [ZmpSegment(support, point, gait.double_support), *later]

    def _planned_steps(self, state: GaitState) -> list[PlannedFootstep]:
        """Return the footsteps ahead as they are planned, that of the present swing first."""
        preview, stance = self._preview, state.stance
        if state.phase is TRANSFER:
            return preview.steps(stance, state.support, self.velocity, PREVIEW_STEPS)
        side = state.swing_side
        landing = stance.compose(self._relative_landing)
        first = PlannedFootstep(side, landing)
        if not state.shortened and preview.ends(stance, side, landing, self.velocity):
            return [first]
        return [first, *preview.steps(landing, side, self.velocity, PREVIEW_STEPS - 1)]

    def _plan_key(self, state: GaitState) -> tuple[object, ...]:
        """Return objects that are replaced when the plan after the present phase changes."""
        return (
            *(self._preview, self.velocity, self._relative_landing),
            *(state.phase, state.support, state.shortened),
        )
