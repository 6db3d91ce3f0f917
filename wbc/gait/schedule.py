"""The gait's phases: who stands, who swings, since when, and what comes next."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from wbc.errors import GaitError
from wbc.gait.dcm_plan import ZmpSegment
from wbc.gait.footsteps import (
    Velocity,
    are_square,
    clamp_to_reach,
    lateral_sign,
    next_placement,
    other,
)
from wbc.gait.lifted import LiftedFoot
from wbc.gait.parameters import GaitParameters
from wbc.gait.planar import Placement, turn, wrap
from wbc.gait.swing import SwingFoot

PREVIEW_STEPS = 3  # the influence of later steps on today's DCM is below e^(-3ωT) < 0.1 %
_HURRY = 0.5  # share of the double support that a late touchdown may take off it
_EARLY_CONTACT_AFTER = 0.6  # share of the swing before which contact is taken for lift-off noise


class Phase(Enum):
    """Which part of the gait cycle."""

    STAND = "stand"  #: both feet, at rest
    TRANSFER = "double"  #: both feet, the weight moves to the support foot
    SWING = "single"  #: the support foot alone


@dataclass(slots=True)
class Feet:
    """Where both soles are, as measured."""

    left: Placement
    right: Placement

    def of(self, side: str) -> Placement:
        """The sole of a side."""
        return self.left if side == "left" else self.right

    @property
    def middle(self) -> complex:
        """Ground point midway between the soles."""
        return 0.5 * (self.left.point + self.right.point)


class Schedule:
    """State machine of the gait.

    stand → transfer → swing → transfer → swing → … → transfer → stand. Time drives it,
    except that a swing ends with contact: early when the foot meets the ground before
    its time, late when it keeps descending until it does.

    Attributes:
        phase: now.
        support: the foot that carries, or that the weight moves to.
        time: since the phase began, s.
        swing: the swing foot's reference during SWING.
        lean: where the weight is while standing or on one leg: 0 over the right sole, 1 over
            the left; walking takes it from the middle.
        swing_load: most of the weight that the other foot may carry while standing, as a share.
        steps: touchdowns so far.
        velocity: what the current step was planned with.
        queue: footsteps given as a list, the next first; they go before the velocity.
        shift: by how much balance moves the present swing's landing place, in the support
            sole's axes, m.
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
        self.lean = 0.5
        self.swing_load = float("inf")
        self.steps = 0
        self.velocity = Velocity()
        self.queue = [] if queue is None else queue
        self._feet = feet
        self.stopping = False
        self._from_middle = True
        self._target_local: tuple[complex, float, float] = (0j, 0.0, 0.0)
        self.shift = 0j

    @property
    def swing_side(self) -> str:
        """The foot that does not carry."""
        return other(self.support)

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
    def planned_target(self) -> Placement:
        """Where the gait wants the present swing to land: fixed in the support sole's axes."""
        stance = self._feet.of(self.support)
        local, yaw, height = self._target_local
        return Placement(stance.to_world(local), wrap(stance.yaw + yaw), stance.height + height)

    @property
    def target(self) -> Placement:
        """Landing place of the present swing: the planned one, moved by `shift` within reach.

        Once the swing is committed, the place it is committed to.
        """
        if self.swing is not None and self.swing.committed:
            return self.swing.target
        planned = self.planned_target
        if self.shift == 0j:
            return planned
        stance = self._feet.of(self.support)
        moved = replace(planned, point=planned.point + self.shift * turn(stance.yaw))
        return clamp_to_reach(stance, self.swing_side, moved, self.gait)

    def update(
        self, dt: float, feet: Feet, velocity: Velocity, loads: dict[str, float] | None
    ) -> None:
        """Move on by dt.

        Args:
            dt: s.
            feet: soles as measured.
            velocity: what is wanted now.
            loads: share of the weight on each side; None when not measured.
        """
        self._feet = feet
        self.time += dt
        if self.phase is Phase.STAND:
            if self.queue or not velocity.still:
                self.velocity = velocity
                self._begin_walking()
        elif self.phase is Phase.TRANSFER:
            if self.time >= self.duration:
                if self.stopping:
                    self._enter(Phase.STAND, 0.0)
                else:
                    self._begin_swing()
        elif isinstance(self.swing, LiftedFoot):
            self.swing.advance(feet.of(self.support))
            if self._is_set_down(self.swing, loads):
                self.swing = None
                self._enter(Phase.STAND, 0.0)
        elif self.swing is not None:
            if self._has_landed(loads):
                self._touch_down(velocity)
            else:
                self.swing.advance(dt, self.target)

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

        The weight has to be over the support foot already (`lean`), the other one unloaded
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

    def _is_set_down(self, foot: LiftedFoot, loads: dict[str, float] | None) -> bool:
        if loads is None:
            return foot.overdue
        return foot.landing and loads[self.swing_side] > self.gait.contact_share

    @property
    def _standing_point(self) -> complex:
        """Where the ZMP is at rest."""
        if self.lean == 0.5:
            return self._feet.middle
        left, right = self._feet.left.point, self._feet.right.point
        return right + self.lean * (left - right)

    def _enter(self, phase: Phase, duration: float) -> None:
        self.phase, self.time, self.duration = phase, 0.0, duration
        self._hold = 0.0

    def _begin_walking(self) -> None:
        side = self.queue[0][0] if self.queue else self._first_swing()
        self.support = other(side)
        self._from_middle = True
        self.stopping = False
        self._enter(Phase.TRANSFER, self.gait.first_transfer)

    def _first_swing(self) -> str:
        way = self.velocity.left or self.velocity.turn
        for side in ("left", "right"):
            if lateral_sign(side) * way > 0.0:
                return side
        # Forward: the foot that is behind, in the direction of travel.
        ahead = self._feet.left.to_local(self._feet.right.point).real * self.velocity.forward
        return "left" if ahead > 0.01 else "right"

    def _begin_swing(self) -> None:
        stance = self._feet.of(self.support)
        target = self._next(stance, self.swing_side, 0)
        target = clamp_to_reach(stance, self.swing_side, target, self.gait)
        self._target_local = (
            stance.to_local(target.point),
            wrap(target.yaw - stance.yaw),
            target.height - stance.height,
        )
        self.shift = 0j
        if self.queue:
            self.queue.pop(0)
        start = self._feet.of(self.swing_side)
        gait = self.gait
        self._enter(Phase.SWING, gait.single_support)
        self.swing = SwingFoot(
            start, self.target, gait.single_support, gait.swing_height, gait.touchdown_speed
        )

    def _has_landed(self, loads: dict[str, float] | None) -> bool:
        if loads is None:
            return self.time >= self.duration
        touching = loads[self.swing_side] > self.gait.contact_share
        return touching and self.progress >= _EARLY_CONTACT_AFTER

    def _touch_down(self, velocity: Velocity) -> None:
        self.steps += 1
        self.swing = None
        square = are_square(self._feet.left, self._feet.right, self.gait)
        ended = not self.queue and velocity.still
        self.stopping = ended and (square or self.velocity.still)
        self.velocity = velocity
        if self.stopping:
            self._enter(Phase.TRANSFER, self.gait.first_transfer)
        else:
            self.support = self.swing_side
            self._from_middle = False
            # The weight keeps its time: after an early touchdown it stays where it is for a
            # while, after a late one it moves faster. The DCM is where it was to be.
            usual = self.gait.double_support
            spare = max(-_HURRY * usual, self.duration - self.time)
            self._enter(Phase.TRANSFER, usual + spare)
            self._hold = max(spare, 0.0)

    def _next(self, stance: Placement, side: str, ahead: int) -> Placement:
        if ahead < len(self.queue):
            return self.queue[ahead][1]
        return next_placement(stance, side, self.velocity, self.gait)

    def preview(self) -> list[tuple[str, Placement]]:
        """The next footsteps, the present swing's landing place first."""
        return self._footsteps(self.target)

    def _footsteps(self, landing: Placement) -> list[tuple[str, Placement]]:
        if self.phase is Phase.STAND or self.stopping or self.lifted is not None:
            return []
        steps: list[tuple[str, Placement]] = []
        side, stance, queued = self.swing_side, self._feet.of(self.support), 0
        if self.phase is Phase.SWING:
            steps.append((side, landing))
            side, stance = other(side), landing
        while len(steps) < PREVIEW_STEPS:
            done = queued >= len(self.queue) and self.velocity.still
            # A stop needs one more step only when the feet are not side by side yet.
            if done and steps and self._closed(steps, side, stance):
                break
            placement = self._next(stance, side, queued)
            placement = clamp_to_reach(stance, side, placement, self.gait)
            steps.append((side, placement))
            side, stance, queued = other(side), placement, queued + 1
        return steps

    def _closed(self, steps: list[tuple[str, Placement]], side: str, last: Placement) -> bool:
        standing = steps[-2][1] if len(steps) > 1 else self._feet.of(self.support)
        left, right = (standing, last) if side == "left" else (last, standing)
        return are_square(left, right, self.gait)

    def zmp_segments(self) -> list[ZmpSegment]:
        """The ZMP from now on, ending at rest midway between the last two feet."""
        return self._segments(self.target)

    def planned_zmp_segments(self) -> list[ZmpSegment]:
        """The same as if balance had not moved the present swing's landing place."""
        return self._segments(self.planned_target)

    def _segments(self, landing: Placement) -> list[ZmpSegment]:
        feet, gait = self._feet, self.gait
        middle = feet.middle
        if self.phase is Phase.STAND or self.lifted is not None:
            at = self._standing_point
            return [ZmpSegment(at, at, 1.0)]
        support = feet.of(self.support).point
        if self.phase is Phase.TRANSFER and self.stopping:
            now = support + (middle - support) * self.progress
            return [ZmpSegment(now, middle, self.remaining), ZmpSegment(middle, middle, 1.0)]
        segments: list[ZmpSegment] = []
        steps = self._footsteps(landing)
        if self.phase is Phase.TRANSFER:
            origin = middle if self._from_middle else feet.of(self.swing_side).point
            now = origin + (support - origin) * self.progress
            hold = max(self._hold - self.time, 0.0)
            segments.append(ZmpSegment(now, now, hold))
            segments.append(ZmpSegment(now, support, self.remaining - hold))
            segments.append(ZmpSegment(support, support, gait.single_support))
        else:
            segments.append(ZmpSegment(support, support, self.remaining))
        at = support
        for k, (_, step) in enumerate(steps):
            if k + 1 == len(steps):
                end = 0.5 * (at + step.point)
                segments.append(ZmpSegment(at, end, gait.first_transfer))
                break
            segments.append(ZmpSegment(at, step.point, gait.double_support))
            segments.append(ZmpSegment(step.point, step.point, gait.single_support))
            at = step.point
        return segments
