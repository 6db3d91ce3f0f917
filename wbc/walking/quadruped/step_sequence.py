"""Steps of a quadruped: which feet swing now, and when they land."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from wbc.gait import STAND, SWING, TRANSFER, Phase, Placement, SwingFoot
from wbc.gait.quadruped_gait import QuadrupedGait

# Shares of the swing's duration after which contact ends it, and after which it ends anyway.
_EARLY, _LATE = 0.6, 1.5


@dataclass(slots=True)
class StepSequence:
    """Phases of a gait in which groups of feet swing in turn.

    A step is a transfer, in which all feet stand, and a swing; it ends when all feet of its group
    have landed.

    Attributes:
        gait: groups and durations.
        phase: part of the step.
        time: since the phase began, s.
        group: index of the group that swings, or swings next.
        swings: side -> reference of a foot in the air.
        steps: number of steps so far.
    """

    gait: QuadrupedGait
    phase: Phase = STAND
    time: float = 0.0
    group: int = 0
    swings: dict[str, SwingFoot] = field(default_factory=dict)
    steps: int = 0

    @property
    def step_time(self) -> float:
        """Time since the step began, s; at most its planned duration."""
        before = self.gait.transfer_duration if self.phase is SWING else 0.0
        return min(before + self.time, self.gait.step_duration)

    @property
    def time_left(self) -> float:
        """Time until the planned end of the step, s."""
        return self.gait.step_duration - self.step_time

    @property
    def next_group(self) -> int:
        """Index of the group after the present one."""
        return (self.group + 1) % len(self.gait.groups)

    @property
    def leaving_load(self) -> float:
        """Share of a full load that the feet which are about to swing may carry."""
        if self.phase is not TRANSFER:
            return 1.0
        return max(1.0 - self.time / self.gait.transfer_duration, 0.0)

    def update(
        self,
        dt: float,
        feet: Mapping[str, Placement],
        contacts: Collection[str] | None,
        walks: bool,
    ) -> None:
        """Move on by dt.

        Args:
            dt: s.
            feet: side -> placement of the foot.
            contacts: sides of the feet on the ground; None when that is not measured, and goes by
                time.
            walks: whether there is to be another step.
        """
        self.time += dt
        if self.phase is STAND:
            if walks:
                self._begin(TRANSFER)
        elif self.phase is TRANSFER:
            if self.time >= self.gait.transfer_duration:
                self._lift(feet)
        else:
            self._land(contacts)
            if not self.swings:
                self.steps += 1
                self.group = self.next_group
                self._begin(TRANSFER if walks else STAND)

    def _begin(self, phase: Phase) -> None:
        self.phase, self.time = phase, 0.0

    def _lift(self, feet: Mapping[str, Placement]) -> None:
        self._begin(SWING)
        gait = self.gait
        for side in gait.groups[self.group]:
            start = feet[side]
            self.swings[side] = SwingFoot(
                start, start, gait.swing_duration, gait.swing_height, gait.touchdown_speed
            )

    def _land(self, contacts: Collection[str] | None) -> None:
        share = self.time / self.gait.swing_duration
        for side in list(self.swings):
            touches = share >= 1.0 if contacts is None else share > _EARLY and side in contacts
            if touches or share > _LATE:
                del self.swings[side]
