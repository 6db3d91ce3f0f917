"""Which soles stand on the ground and what they carry, from the foot force sensors."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
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
        return 1.0 if load >= self.full else max(1.0, self.full / max(load, _MIN_LOAD))


class ContactDetector:
    """Validates foot wrenches once per tick and decides which soles stand.

    Args:
        robot: its soles and weight.
        trigger: the thresholds.

    Attributes:
        names: names of the soles, in the order of all lists here.
        stands: per sole, whether it stands.
        contacts: names of the soles that stand.
        slip: per sole, the factor on its drift over the last period; 0 for one in the air.
    """

    def __init__(self, robot: Robot, trigger: ContactTrigger | None = None) -> None:
        self.names = tuple(sole.name for sole in robot.soles)
        self.trigger = ContactTrigger() if trigger is None else trigger
        self._weight = robot.weight
        self.reset()

    def reset(self) -> None:
        """Start with all soles in the air."""
        self.stands = [False] * len(self.names)
        self.slip: tuple[float, ...] = (0.0,) * len(self.names)
        self.contacts: tuple[str, ...] = ()

    def update(
        self, wrenches: Mapping[str, np.ndarray], contacts: Collection[str] | None = None
    ) -> dict[str, float] | None:
        """Take in the foot wrenches of a tick; return each sole's share of the robot's weight.

        Args:
            wrenches: sole name -> (6,) wrench from the ground in sole axes; N, N·m. Without any,
                the soles that stand are taken to carry the same, and `decide` is somebody else's.
            contacts: names of the soles that stand, instead of deciding by the loads.

        Raises:
            MeasurementError: a sole is missing, or a wrench has a wrong shape or is not finite.
            ContactError: an unknown sole in `contacts`.
        """
        given = None if contacts is None else self._validated(contacts)
        names, before, trigger = self.names, self.stands, self.trigger
        loads: dict[str, float] | None = None
        if wrenches:
            stands: list[bool] = []
            slip: list[float] = []
            loads = {}
            for i, name in enumerate(names):
                try:
                    f_x, f_y, f_z, m_x, m_y, m_z = wrenches[name].tolist()
                    finite = math.isfinite(f_x + f_y + f_z + m_x + m_y + m_z)
                except (KeyError, AttributeError, TypeError, ValueError):
                    finite = False
                if not finite:
                    raise MeasurementError(
                        f"measurement.foot_wrenches['{name}'] is {wrenches.get(name)!r}: it needs "
                        "six finite numbers for every sole, or no entries at all without foot "
                        "sensors"
                    )
                load = loads[name] = f_z / self._weight
                stood = before[i]
                slip.append(trigger.slip_factor(load) if stood else 0.0)
                stands.append(load > (trigger.off if stood else trigger.on))
            self.slip = tuple(slip)
            self.decide(stands if given is None else given)
        else:
            equal = trigger.slip_factor(1.0 / len(names))
            self.slip = tuple([equal if stood else 0.0 for stood in before])
            if given is not None:
                self.decide(given)
        return loads

    def _validated(self, contacts: Collection[str]) -> list[bool]:
        unknown = [c for c in contacts if c not in self.names]
        if unknown:
            raise ContactError(f"no sole is called '{unknown[0]}'; there are: {list(self.names)}")
        return [name in contacts for name in self.names]

    def decide(self, stands: list[bool]) -> None:
        """Set which soles stand."""
        if stands != self.stands:
            self.stands = stands
            self.contacts = tuple(name for name, now in zip(self.names, stands, strict=True) if now)
