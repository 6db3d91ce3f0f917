"""The footsteps ahead, and the DCM with which the weight should arrive on a foot."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.gait.footsteps import Velocity, are_square, clamp_footstep, next_footstep, other_side
from wbc.gait.parameters import GaitParameters
from wbc.gait.planners.dcm import ZmpSegment, solve_dcm
from wbc.gait.state import PlannedFootstep
from wbc.geometry.planar import Placement

_ORIGIN = Placement(0j, 0.0)


class FootstepPreview:
    """The future after a foot has taken the weight: further steps, then rest.

    Steps that follow a velocity are always the same seen from that foot, so the DCM that they
    ask for is computed once, in the foot's axes. Given footsteps are fixed in the world instead.

    Args:
        gait: timing of the steps and workspace of the feet.
        given: given footsteps, the next first; they take precedence over the velocity.
    """

    def __init__(self, gait: GaitParameters, given: Sequence[PlannedFootstep]) -> None:
        self.gait = gait
        self.given = given
        self._cached_for: tuple[str, int] | None = None
        self._cached_velocity: Velocity | None = None
        self._cached = 0j

    def next(self, stance: Placement, side: str, velocity: Velocity, before: int = 0) -> Placement:
        """Where the foot of a side lands beside `stance` when `before` steps come before it."""
        if before < len(self.given):
            wanted = self.given[before].placement
        else:
            wanted = next_footstep(stance, side, velocity, self.gait)
        return clamp_footstep(stance, side, wanted, self.gait)

    def ends(
        self, stance: Placement, side: str, step: Placement, velocity: Velocity, before: int = 0
    ) -> bool:
        """Whether nothing more is wanted after a step, and it puts the feet side by side."""
        if before < len(self.given) or not velocity.is_zero:
            return False
        left, right = (step, stance) if side == "left" else (stance, step)
        return are_square(left, right, self.gait)

    def steps(
        self, foot: Placement, side: str, velocity: Velocity, most: int
    ) -> list[PlannedFootstep]:
        """The footsteps after the weight is on the foot of a side: one, and up to `most`."""
        steps: list[PlannedFootstep] = []
        while len(steps) < most:
            side = other_side(side)
            step = self.next(foot, side, velocity, len(steps))
            steps.append(PlannedFootstep(side, step))
            if self.ends(foot, side, step, velocity, len(steps)):
                break
            foot = step
        return steps

    def arrival_dcm(self, foot: Placement, side: str, velocity: Velocity, most: int) -> complex:
        """The DCM with which the weight should arrive on a foot, ground point, m.

        Args:
            foot: placement of the standing foot.
            side: side of the standing foot.
            velocity: velocity of the steps that follow.
            most: number of steps that are looked ahead.
        """
        if self.given:
            return self._arrival_dcm(foot, side, velocity, most)
        if velocity is not self._cached_velocity or (side, most) != self._cached_for:
            self._cached = self._arrival_dcm(_ORIGIN, side, velocity, most)
            self._cached_for, self._cached_velocity = (side, most), velocity
        return foot.to_world(self._cached)

    def _arrival_dcm(self, foot: Placement, side: str, velocity: Velocity, most: int) -> complex:
        places = [step.placement.point for step in self.steps(foot, side, velocity, most)]
        return solve_dcm(zmp_over(foot.point, places, self.gait), self.gait.omega).dcm


def zmp_over(foot: complex, steps: Sequence[complex], gait: GaitParameters) -> list[ZmpSegment]:
    """The ZMP from its arrival on a foot, over further ones, to rest between the last two."""
    segments = [ZmpSegment(foot, foot, gait.single_support)]
    for step in steps[:-1]:
        segments.append(ZmpSegment(foot, step, gait.double_support))
        segments.append(ZmpSegment(step, step, gait.single_support))
        foot = step
    segments.append(ZmpSegment(foot, 0.5 * (foot + steps[-1]), gait.first_transfer))
    return segments
