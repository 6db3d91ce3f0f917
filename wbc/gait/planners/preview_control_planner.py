"""Planner by preview control: the analytic planner's footsteps, with a ZMP without corners."""

from __future__ import annotations

from wbc.gait.planners.dcm import DcmReference, dcm_after
from wbc.gait.planners.dcm_planner import DcmPlanner
from wbc.gait.planners.planner import StepPlan
from wbc.gait.planners.preview_control import Preview, PreviewControlGains
from wbc.gait.state import GaitCommand, GaitState
from wbc.geometry.planar import Placement

# Share of the jump of the analytic DCM at the beginning of a walk that preview control takes, by a
# ZMP that first moves the other way; the rest is an error for the feedback. Each jumps by half.
_START_SHARE = 0.5


class PreviewControlPlanner(DcmPlanner):
    """Plans a centre of mass whose ZMP follows that of the footsteps with little jerk.

    Footsteps and their ZMP are those of the `DcmPlanner`. The ZMP of the plan follows it by preview
    control (`PreviewControlGains`): it starts to move before and arrives after the ideal one, which
    has corners. The DCM of the plan differs from the analytic one ξ by y, and its ZMP from the
    analytic one p by d, which obey the linear inverted pendulum as well, `ẏ = ω (y − d)`. A plan
    that changes at once, because a foot lands elsewhere or sooner, changes ξ and p; the
    difference y stays, and preview control takes it back.
    """

    def __init__(self) -> None:
        super().__init__()
        self._gains: PreviewControlGains | None = None
        self._com = self._zmp = 0j  # of this tick, ground points, m
        self._difference = 0j  # y of this tick, m
        self._next = (0j, 0j, 0j)  # the same three of the next tick
        self._later: Preview = (0j, 0j, 0j)  # at the end of the phase, in the support sole's axes
        self._later_of: tuple[object, ...] = ()

    def reset(self, state: GaitState) -> None:
        """See `Planner.reset`."""
        super().reset(state)
        self._rest_at(state.standing_point)

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """See `Planner.update`."""
        plan = super().update(state, command, dt)
        if state.at_rest:
            self._rest_at(state.standing_point)
            return plan
        com, zmp, difference = self._com, self._zmp, self._difference = self._next
        omega = state.gait.omega
        analytic = super().reference(state).dcm
        if state.starting and state.time == 0.0 and not state.recovering:
            difference = self._difference = _START_SHARE * (com - analytic)
        gains = self._gains
        if gains is None or gains.omega != omega:
            gains = self._gains = PreviewControlGains(omega)
            self._later_of = ()
        segments = self._present_zmp(state)
        preview = gains.preview(segments, self._later_preview(gains, state))
        dcm = analytic + difference
        velocity, acceleration = omega * (dcm - com), omega * omega * (com - zmp)
        jerk = gains.jerk(com, velocity, acceleration, preview)
        com += dt * (velocity + dt * (acceleration / 2.0 + dt * jerk / 6.0))
        velocity += dt * (acceleration + dt * jerk / 2.0)
        acceleration += dt * jerk
        after = dcm_after(segments[0], analytic, dt, omega)
        self._next = (com, com - acceleration / omega**2, com + velocity / omega - after)
        return plan

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """See `Planner.reference`."""
        analytic = super().reference(state, landing)
        if state.at_rest:
            return analytic
        omega, zmp = state.gait.omega, self._zmp
        dcm = analytic.dcm + self._difference
        drift = analytic.dcm_velocity - omega * (analytic.dcm - analytic.zmp)
        return DcmReference(dcm, omega * (dcm - zmp) + drift, zmp)

    def _rest_at(self, point: complex) -> None:
        self._com, self._zmp, self._difference = self._next = (point, point, 0j)

    def _later_preview(self, gains: PreviewControlGains, state: GaitState) -> Preview | None:
        """Return the preview at the end of the present phase; None if the robot then stands.

        Seen from the support sole it is the same in every tick of a phase, as long as nothing
        else is planned.
        """
        if state.stopping:
            return None
        stance = state.stance
        if self._preview.given:
            return gains.preview(self._later_zmp(state, stance))
        plan = self._plan_key(state)
        if len(plan) != len(self._later_of) or any(
            a is not b for a, b in zip(plan, self._later_of, strict=True)
        ):
            self._later = gains.preview(self._later_zmp(state, Placement(0j, 0.0)))
            self._later_of = plan
        a, b, c = self._later
        return (stance.to_world(a), stance.to_world(b), stance.to_world(c))
