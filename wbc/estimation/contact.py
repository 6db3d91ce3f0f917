"""Which soles stand on the ground, told from their forces."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ContactTrigger:
    """A Schmitt trigger on the normal force as a share of the robot's weight.

    Attributes:
        on: share above which a sole in the air is taken to stand.
        off: share below which a standing sole is taken to lift.
        full: share from which on a sole is trusted fully; below, its assumed
            wandering grows as full / share, for a lightly loaded sole rolls and slips.
    """

    on: float = 0.10
    off: float = 0.05
    full: float = 0.4

    def stands(self, share: float, before: bool) -> bool:
        """Whether a sole that carries `share` of the weight stands now."""
        return share > (self.off if before else self.on)

    def slip_factor(self, share: float) -> float:
        """Factor on the wandering of a sole that carries `share` of the weight."""
        return max(1.0, self.full / max(share, 0.02))
