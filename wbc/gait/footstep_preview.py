"""The footsteps ahead, and the DCM with which the weight should arrive on a foot."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.gait.dcm import ZmpSegment, solve_dcm
from wbc.gait.footsteps import Velocity, are_square, clamp_footstep, next_footstep, other_side
from wbc.gait.parameters import GaitParameters
from wbc.geometry.planar import Placement

_ORIGIN = Placement(0j, 0.0)


class FootstepPreview:
    """What comes after a foot has taken the weight: further steps, then rest.

    Steps that follow a velocity are always the same seen from that foot, so the DCM that they
    ask for is found once, in the foot's axes. Given footsteps are fixed in the world instead.

    Args:
        gait: timing and reach of the steps.
        queue: given footsteps, the next first; they go before the velocity.
    """

    def __init__(self, gait: GaitParameters, queue: list[tuple[str, Placement]]) -> None:
        self._gait = gait
        self._queue = queue
        self._known_for: tuple[str, Velocity, int] | None = None
        self._known = 0j

    def next(self, stance: Placement, side: str, velocity: Velocity, before: int = 0) -> Placement:
        """Where the foot of a side lands beside `stance` when `before` steps come before it."""
        if before < len(self._queue):
            wanted = self._queue[before][1]
        else:
            wanted = next_footstep(stance, side, velocity, self._gait)
        return clamp_footstep(stance, side, wanted, self._gait)

    def ends(
        self, stance: Placement, side: str, step: Placement, velocity: Velocity, before: int = 0
    ) -> bool:
        """Nothing more is wanted after a step, and it closes the feet."""
        if before < len(self._queue) or not velocity.is_zero:
            return False
        left, right = (step, stance) if side == "left" else (stance, step)
        return are_square(left, right, self._gait)

    def steps(
        self, foot: Placement, side: str, velocity: Velocity, most: int
    ) -> list[tuple[str, Placement]]:
        """The footsteps after the weight is on the foot of a side: one, and up to `most`."""
        steps: list[tuple[str, Placement]] = []
        while len(steps) < most:
            side = other_side(side)
            step = self.next(foot, side, velocity, len(steps))
            steps.append((side, step))
            if self.ends(foot, side, step, velocity, len(steps)):
                break
            foot = step
        return steps

    def arrival_dcm(self, foot: Placement, side: str, velocity: Velocity, most: int) -> complex:
        """The DCM with which the weight should arrive on a foot, ground point, m.

        Args:
            foot: where it stands.
            side: of it.
            velocity: of the steps that follow.
            most: how many of them count.
        """
        if self._queue:
            return self._arrival_dcm(foot, side, velocity, most)
        asked = (side, velocity, most)
        if asked != self._known_for:
            self._known = self._arrival_dcm(_ORIGIN, side, velocity, most)
            self._known_for = asked
        return foot.to_world(self._known)

    def _arrival_dcm(self, foot: Placement, side: str, velocity: Velocity, most: int) -> complex:
        places = [step.point for _, step in self.steps(foot, side, velocity, most)]
        return solve_dcm(zmp_over(foot.point, places, self._gait), self._gait.omega).dcm


def zmp_over(foot: complex, steps: Sequence[complex], gait: GaitParameters) -> list[ZmpSegment]:
    """The ZMP from its arrival on a foot, over further ones, to rest between the last two."""
    segments = [ZmpSegment(foot, foot, gait.single_support)]
    for step in steps[:-1]:
        segments.append(ZmpSegment(foot, step, gait.double_support))
        segments.append(ZmpSegment(step, step, gait.single_support))
        foot = step
    segments.append(ZmpSegment(foot, 0.5 * (foot + steps[-1]), gait.first_transfer))
    return segments
