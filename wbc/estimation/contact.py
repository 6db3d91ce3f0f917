"""Which soles stand on the ground and what they carry, from the foot force sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wbc.errors import ContactError, MeasurementError
from wbc.robot import Robot

_MIN_LOAD = 0.02  # with less, a sole is trusted no less


@dataclass(frozen=True, slots=True)
class ContactTrigger:
    """A Schmitt trigger on the normal force as a share of the robot's weight.

    Attributes:
        on: load above which a sole in the air counts as standing.
        off: load below which a standing sole counts as lifted.
        full: load from which on a sole is trusted fully; below, its assumed drift grows
            as full / load, because a lightly loaded sole rolls and slips.

    Raises:
        ContactError: thresholds that are not 0 <= off <= on, or `full` not positive.
    """

    on: float = 0.10
    off: float = 0.05
    full: float = 0.4

    def __post_init__(self) -> None:
        if not (0.0 <= self.off <= self.on and math.isfinite(self.on)):
            raise ContactError(
                f"ContactTrigger: on = {self.on} and off = {self.off} are shares of the weight "
                "with 0 <= off <= on"
            )
        if not (math.isfinite(self.full) and self.full > 0.0):
            raise ContactError(f"ContactTrigger: full = {self.full} must be positive")

    def slip_factor(self, load: float) -> float:
        """Return the factor on the drift of a sole with this load, a share of the weight."""
        return max(1.0, self.full / max(load, _MIN_LOAD))


class ContactDetector:
    """Validates foot wrenches once per tick and decides which soles stand.

    Args:
        robot: its soles and weight.
        trigger: the thresholds.

    Attributes:
        names: of the soles, in the order of all lists here.
        stands: per sole, whether it stands.
        contacts: names of the soles that stand.
    """

    def __init__(self, robot: Robot, trigger: ContactTrigger | None = None) -> None:
        self.names = tuple(sole.name for sole in robot.soles)
        self.trigger = ContactTrigger() if trigger is None else trigger
        self._weight = robot.weight
        self.reset()

    def reset(self) -> None:
        """Start with all soles in the air."""
        self.stands = [False] * len(self.names)
        self.contacts: tuple[str, ...] = ()

    def loads(self, wrenches: Mapping[str, np.ndarray]) -> dict[str, float] | None:
        """Return the normal force of each sole as a share of the weight; None without wrenches.

        Args:
            wrenches: sole name -> (6,) wrench from the ground in sole axes; N, N·m.

        Raises:
            MeasurementError: a sole is missing, or a wrench has a wrong shape or is not finite.
        """
        if not wrenches:
            return None
        loads: dict[str, float] = {}
        for name in self.names:
            wrench = wrenches.get(name)
            if wrench is None or wrench.shape != (6,) or not math.isfinite(wrench.dot(wrench)):
                raise MeasurementError(
                    f"measurement.foot_wrenches['{name}'] is {wrench!r}: it needs six finite "
                    "numbers for every sole, or no entries at all without foot sensors"
                )
            loads[name] = wrench.item(2) / self._weight
        return loads

    def update(self, loads: Mapping[str, float]) -> None:
        """Decide by the loads, shares of the weight."""
        on, off = self.trigger.on, self.trigger.off
        self.decide(
            [
                loads[name] > (off if before else on)
                for name, before in zip(self.names, self.stands, strict=True)
            ]
        )

    def decide(self, stands: list[bool]) -> None:
        """Set which soles stand."""
        if stands != self.stands:
            self.stands = stands
            self.contacts = tuple(name for name, now in zip(self.names, stands, strict=True) if now)
