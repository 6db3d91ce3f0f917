"""What may step in the walker's place for a while."""

from __future__ import annotations

from typing import Protocol

from wbc.command import Command
from wbc.estimation import Estimate
from wbc.telemetry import Balance, Telemetry


class ControllerOverride(Protocol):
    """Steps in the walker's place, for a motion that leaves the ground."""

    def step(self, estimate: Estimate) -> Command:
        """One tick."""

    def abandon(self) -> None:
        """Return to standing as soon as that is safe."""

    @property
    def done(self) -> bool:
        """It stands, and may be relieved."""

    @property
    def balance(self) -> Balance:
        """How the balance is."""

    @property
    def telemetry(self) -> Telemetry:
        """What it sees and intends, for observers."""

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""
