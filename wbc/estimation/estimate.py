"""The estimate of state, contacts and foot loads from one measurement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from wbc.state import State


# Not frozen: every tick makes one, and a frozen one takes three times as long.
@dataclass(slots=True)
class Estimate:
    """State, contacts and foot loads of one control period, decided once for all who need them.

    `Estimate(state)` is that of a robot without foot sensors.

    Attributes:
        state: estimated configuration and velocity.
        contacts: names of the soles that stand on the ground.
        loads: sole name -> measured normal force as a share of the robot's weight; None when
            the robot has no foot sensors: `contacts` may be inferred then, and controllers go
            by the time of their plan.
        foot_wrenches: sole name -> (6,) measured force then moment that the ground exerts on
            the foot, at the sole's centre, in sole axes; N, N·m. Finite; empty when the robot
            has no foot sensors.
    """

    state: State
    contacts: tuple[str, ...] = ()
    loads: Mapping[str, float] | None = None
    foot_wrenches: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __repr__(self) -> str:
        x, y, z = self.state.q[:3].tolist()
        loads = (
            "not measured"
            if self.loads is None
            else ", ".join(f"{name} {100.0 * load:.0f} %" for name, load in self.loads.items())
        )
        return (
            f"Estimate(base at [{x:.3f}, {y:.3f}, {z:.3f}] m, "
            f"contacts: {', '.join(self.contacts) or 'none'}, loads: {loads})"
        )
