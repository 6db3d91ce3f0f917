"""Which soles stand on the ground and what they carry, from the foot force sensors."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from wbc.errors import ContactError, MeasurementError, short_repr
from wbc.estimation.kernels.loads import LOAD_LIMITS, read_load
from wbc.estimation.readings import is_vector_of_numbers
from wbc.robot import Robot


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


class ContactDetector:
    """Validates foot wrenches once per tick and decides which soles stand.

    Args:
        robot: its soles and weight.
        trigger: the thresholds.

    Attributes:
        names: names of the soles, in the order of all lists here.
        stands: per sole, whether it stands.
        contacts: names of the soles that stand.
        slip: (n,) per sole, the factor on its drift over the last period; 0 for one in the air.
    """

    def __init__(self, robot: Robot, trigger: ContactTrigger | None = None) -> None:
        self.names = tuple(sole.name for sole in robot.soles)
        trigger = ContactTrigger() if trigger is None else trigger
        self._limits = np.array(
            [(trigger.on, trigger.off, trigger.full, robot.weight)], dtype=LOAD_LIMITS
        )
        count = len(self.names)
        self.slip = np.zeros(count)
        self._equal_share = np.array([0.0, 0.0, robot.weight / count, 0.0, 0.0, 0.0])
        self.reset()

    def reset(self) -> None:
        """Start with all soles in the air."""
        self.stands = [False] * len(self.names)
        self.slip[:] = 0.0
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
        before, limits, slip = self.stands, self._limits, self.slip
        if not wrenches:
            for i, stood in enumerate(before):
                read_load(self._equal_share, limits, stood, slip, i)
            if given is not None:
                self.decide(given)
            return None
        loads: dict[str, float] = {}
        stands: list[bool] = []
        for i, name in enumerate(self.names):
            try:
                load, now = read_load(wrenches[name], limits, before[i], slip, i)
            except (AttributeError, KeyError, TypeError):  # other numbers than floats, read-only, …
                wrench = _as_floats(name, wrenches.get(name))
                load, now = read_load(wrench, limits, before[i], slip, i)
            if load != load:  # NaN
                raise _refusal(name, wrenches[name])
            loads[name] = load
            stands.append(now)
        self.decide(stands if given is None else given)
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


def _as_floats(name: str, wrench: object) -> np.ndarray:
    if is_vector_of_numbers(wrench):
        return np.array(wrench, dtype=float)
    raise _refusal(name, wrench)


def _refusal(name: str, wrench: object) -> MeasurementError:
    return MeasurementError(
        f"measurement.foot_wrenches['{name}'] is {short_repr(wrench)}: it needs six finite numbers "
        "for every sole, or no entries at all without foot sensors"
    )
