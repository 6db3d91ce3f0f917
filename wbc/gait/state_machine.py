"""The gait's phases: who stands, who swings, since when, and what comes next."""

from __future__ import annotations

import math
from collections.abc import Collection
from enum import Enum

from wbc.errors import GaitError
from wbc.gait.dcm import DcmReference, ZmpSegment, solve_dcm
from wbc.gait.footstep_preview import FootstepPreview
from wbc.gait.footsteps import Velocity, first_swing_side, other_side
from wbc.gait.lifted_foot import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.swing_foot import SwingFoot
from wbc.gait.touchdown import Touchdown
from wbc.gait.velocity_filter import VelocityFilter
from wbc.geometry.planar import Feet, Placement

PREVIEW_STEPS = 3  # the influence of later steps on today's DCM is below e^(-3ωT) < 0.1 %
_SHORTENING = 0.5  # share of the double support that a late touchdown may take off it
_EARLY_CONTACT_AFTER = 0.6  # share of the swing before which contact is taken for lift-off noise


class Phase(Enum):
    """Which part of the gait cycle."""

    STAND = "stand"  #: both feet, at rest
    TRANSFER = "double"  #: both feet, the weight moves to the support foot
    SWING = "single"  #: the support foot alone


class GaitStateMachine:
    """State machine of the gait.

    stand → transfer → swing → transfer → swing → … → transfer → stand. Time drives it,
    except that a swing ends with contact: early when the foot meets the ground before
    its time, late when it keeps descending until it does.

    Attributes:
        phase: now.
        support: the foot that carries, or that the weight moves to.
        time: since the phase began, s.
        swing: the swing foot's reference during SWING.
        weight_shift: where the weight is while standing or on one leg: 0 over the right
            sole, 1 over the left. Walking starts from the middle.
        swing_load: most of the weight that the other foot may carry while standing, as a share.
        steps: touchdowns so far.
        velocity: what the current step was planned with.
        queue: footsteps given as a list, the next first; they go before the velocity.
        landing: where the present swing is to land.
    """

    def __init__(
        self,
        gait: GaitParameters,
        feet: Feet,
        queue: list[tuple[str, Placement]] | None = None,
    ) -> None:
        self.gait = gait
        self.phase = Phase.STAND
        self.support = "left"
        self.time = 0.0
        self.duration = 0.0
        self._hold = 0.0  # time at the start of a transfer in which the weight stays
        self.swing: SwingFoot | LiftedFoot | None = None
        self.weight_shift = 0.5
        self.swing_load = float("inf")
        self.steps = 0
        self.velocity = Velocity()
        self.queue = [] if queue is None else queue
        self._preview = FootstepPreview(gait, self.queue)
        self._feet = feet
        self.stopping = False
        self._from_middle = True
        self.landing = Touchdown()
        self._velocity_filter = VelocityFilter()
        self._drift = 0j  # of the planned DCM, as the velocity changes, m/s

    @property
    def swing_side(self) -> str:
        """The foot that does not carry."""
        return other_side(self.support)

    @property
    def progress(self) -> float:
        """Share of the swing or of the weight's move that is over, 0 to 1."""
        whole = self.duration - self._hold
        return min(max(self.time - self._hold, 0.0) / whole, 1.0) if whole > 0.0 else 1.0

    @property
    def remaining(self) -> float:
        """Time to the planned end of the phase, s; 0 when overdue."""
        return max(self.duration - self.time, 0.0)

    @property
    def target(self) -> Placement:
        """Landing place of the present swing; once it is frozen, the frozen one."""
        if self.swing is not None and self.swing.target_frozen:
            return self.swing.target
        return self.landing.adjusted(self._feet.of(self.support), self.swing_side, self.gait)

    def update(
        self, dt: float, feet: Feet, velocity: Velocity, contacts: Collection[str] | None
    ) -> None:
        """Move on by dt.

        Args:
            dt: s.
            feet: soles as measured.
            velocity: what is wanted now.
            contacts: sides whose soles stand; None without foot sensors: then contact goes by
                time.
        """
        self._feet = feet
        self.time += dt
        if self.phase is Phase.STAND:
            if self.queue or not velocity.is_zero:
                self.velocity = velocity
                self._begin_walking()
        elif self.phase is Phase.TRANSFER:
            if self.time >= self.duration:
                if self.stopping:
                    self._enter(Phase.STAND, 0.0)
                else:
                    self._begin_swing()
            elif not self.stopping:
                self._follow(velocity, dt)
        elif isinstance(self.swing, LiftedFoot):
            self.swing.advance(feet.of(self.support))
            if self._is_set_down(self.swing, contacts):
                self.swing = None
                self._enter(Phase.STAND, 0.0)
        elif self.swing is not None:
            if self._has_landed(contacts):
                self._touch_down(velocity)
            else:
                self.landing.follow_stance(feet.of(self.support))
                self._follow(velocity, dt)
                self.swing.advance(dt, self.target)

    def change_gait(self, gait: GaitParameters) -> None:
        """Go on with other parameters; the present phase keeps its duration."""
        self.gait = gait
        if isinstance(self.swing, SwingFoot):
            self.swing.set_apex(gait.swing_height)
        self._preview = FootstepPreview(gait, self.queue)

    def stand_on(self, side: str) -> None:
        """While standing: which foot the ground holds exactly, and is not to be lifted.

        Raises:
            GaitError: it is not standing.
        """
        if self.phase is not Phase.STAND:
            raise GaitError(f"stand_on('{side}') in phase {self.phase.name}: only while standing")
        self.support = side

    def lift(self) -> LiftedFoot:
        """Stand on the support foot alone from now on; returns the other one's reference.

        The weight has to be over the support foot already (`weight_shift`), the other one unloaded
        (`swing_load`). It ends when the foot is lowered with `landing` set and feels the ground.

        Raises:
            GaitError: it is not standing.
        """
        if self.phase is not Phase.STAND:
            raise GaitError(f"lift() in phase {self.phase.name}: only while standing")
        lifted = LiftedFoot(self._feet.of(self.swing_side), self._feet.of(self.support))
        self.swing = lifted
        self._enter(Phase.SWING, math.inf)
        return lifted

    @property
    def lifted(self) -> LiftedFoot | None:
        """The foot that is held up, if one is."""
        return self.swing if isinstance(self.swing, LiftedFoot) else None

    def _is_set_down(self, foot: LiftedFoot, contacts: Collection[str] | None) -> bool:
        if contacts is None:
            return foot.overdue
        return foot.expects_contact and self.swing_side in contacts

    @property
    def _standing_point(self) -> complex:
        """Where the ZMP is at rest."""
        if self.weight_shift == 0.5:
            return self._feet.middle
        left, right = self._feet.left.point, self._feet.right.point
        return right + self.weight_shift * (left - right)

    def _enter(self, phase: Phase, duration: float) -> None:
        self._drift = 0j
        self.phase, self.time, self.duration = phase, 0.0, duration
        self._hold = 0.0

    def _begin_walking(self) -> None:
        side = self.queue[0][0] if self.queue else first_swing_side(self._feet, self.velocity)
        self.support = other_side(side)
        self._from_middle = True
        self.stopping = False
        self._enter(Phase.TRANSFER, self.gait.first_transfer)

    def _follow(self, wanted: Velocity, dt: float) -> None:
        """Go over to another velocity within the step; landing place and DCM move along.

        Slower the less time is left until the foot lands, for the sole's own ZMP has to move the
        DCM. Not in the last step, which is planned to come to rest; and none becomes the last
        one: that is for the next.
        """
        self._drift = 0j
        if self.queue or self.landing.is_given or self.velocity.is_zero or self.velocity == wanted:
            return
        share = self.remaining / self.duration if self.phase is Phase.SWING else 1.0
        velocity = self._velocity_filter.update(self.velocity, wanted, share, dt, self.gait)
        if velocity.is_zero or velocity == self.velocity:
            return
        before = self._steady_reference().dcm
        self.velocity = velocity
        if self.swing is not None and not self.swing.target_frozen:
            self._plan_landing()
        self._drift = (self._steady_reference().dcm - before) / dt

    def _begin_swing(self) -> None:
        self._plan_landing()
        self.landing.adjustment = 0j
        self.landing.is_given = bool(self.queue)
        if self.queue:
            self.queue.pop(0)
        start = self._feet.of(self.swing_side)
        gait = self.gait
        self._enter(Phase.SWING, gait.single_support)
        self.swing = SwingFoot(
            start, self.target, gait.single_support, gait.swing_height, gait.touchdown_speed
        )

    def _plan_landing(self) -> None:
        stance = self._feet.of(self.support)
        self.landing.plan(stance, self._preview.next(stance, self.swing_side, self.velocity))

    def _has_landed(self, contacts: Collection[str] | None) -> bool:
        if contacts is None:
            return self.time >= self.duration
        return self.swing_side in contacts and self.progress >= _EARLY_CONTACT_AFTER

    def _touch_down(self, velocity: Velocity) -> None:
        self.steps += 1
        stance = self._feet.of(self.support)
        # A step that was planned as the last one is: the DCM is on its way to rest, and a wish
        # to go on that came too late for it waits until the robot stands.
        last = self._preview.ends(stance, self.swing_side, self.target, self.velocity)
        self.swing = None
        self.landing.is_given = False
        ended = not self.queue and velocity.is_zero
        self.stopping = last or (ended and self.velocity.is_zero)
        self.velocity = velocity
        self._velocity_filter.reset()
        if self.stopping:
            self._enter(Phase.TRANSFER, self.gait.first_transfer)
        else:
            self.support = self.swing_side
            self._from_middle = False
            # The weight keeps its time: after an early touchdown it stays where it is for a
            # while, after a late one it moves faster. The DCM is where it was to be.
            usual = self.gait.double_support
            spare = max(-_SHORTENING * usual, self.duration - self.time)
            self._enter(Phase.TRANSFER, usual + spare)
            self._hold = max(spare, 0.0)

    def preview(self) -> list[tuple[str, Placement]]:
        """The next footsteps, the present swing's landing place first."""
        if self.phase is Phase.STAND or self.stopping or self.lifted is not None:
            return []
        stance = self._feet.of(self.support)
        if self.phase is Phase.TRANSFER:
            return self._preview.steps(stance, self.support, self.velocity, PREVIEW_STEPS)
        side, landing = self.swing_side, self.target
        first = (side, landing)
        if self._preview.ends(stance, side, landing, self.velocity):
            return [first]
        return [first, *self._preview.steps(landing, side, self.velocity, PREVIEW_STEPS - 1)]

    def reference(self) -> DcmReference:
        """Where DCM and ZMP should be now, for the weight to go on over the footsteps."""
        return self._drifting(self._steady_reference())

    def _steady_reference(self) -> DcmReference:
        if self.phase is Phase.STAND or self.lifted is not None:
            at = self._standing_point
            return DcmReference(at, 0j, at)
        if self.phase is Phase.SWING:
            return self._landing_reference(self.target)
        feet, omega = self._feet, self.gait.omega
        stance = feet.of(self.support)
        support, middle = stance.point, feet.middle
        if self.stopping:
            now = support + (middle - support) * self.progress
            return solve_dcm([ZmpSegment(now, middle, self.remaining)], omega)
        origin = middle if self._from_middle else feet.of(self.swing_side).point
        now = origin + (support - origin) * self.progress
        hold = max(self._hold - self.time, 0.0)
        move = ZmpSegment(now, support, self.remaining - hold)
        final = self._preview.arrival_dcm(stance, self.support, self.velocity, PREVIEW_STEPS)
        return solve_dcm([ZmpSegment(now, now, hold), move], omega, final)

    def planned_reference(self) -> DcmReference:
        """During a swing: the same as if balance had not moved its landing place."""
        return self._drifting(self._landing_reference(self.landing.planned))

    def _drifting(self, reference: DcmReference) -> DcmReference:
        return reference._replace(dcm_velocity=reference.dcm_velocity + self._drift)

    def _landing_reference(self, landing: Placement) -> DcmReference:
        gait, preview, side = self.gait, self._preview, self.swing_side
        stance = self._feet.of(self.support)
        support = stance.point
        alone = ZmpSegment(support, support, self.remaining)
        if preview.ends(stance, side, landing, self.velocity):
            rest = 0.5 * (support + landing.point)
            return solve_dcm([alone, ZmpSegment(support, rest, gait.first_transfer)], gait.omega)
        over = ZmpSegment(support, landing.point, gait.double_support)
        final = preview.arrival_dcm(landing, side, self.velocity, PREVIEW_STEPS - 1)
        return solve_dcm([alone, over], gait.omega, final)
