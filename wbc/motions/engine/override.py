"""The protocol of a controller that replaces the walker for a while."""

from __future__ import annotations

from typing import Protocol

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.telemetry import ContactPlan, Telemetry


class ControllerOverride(Protocol):
    """A controller that steps instead of the walker, for a motion that leaves the ground."""

    def step(self, estimate: Estimate) -> Command:
        """Compute the command of one tick."""

    def abandon(self) -> None:
        """Return to standing as soon as that is safe."""

    @property
    def done(self) -> bool:
        """Whether the robot stands again, so that the walker may resume."""

    @property
    def telemetry(self) -> Telemetry:
        """Measured and planned quantities after the last tick, for observers."""

    @property
    def contact_plan(self) -> ContactPlan:
        """The present support and the planned footsteps."""

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
