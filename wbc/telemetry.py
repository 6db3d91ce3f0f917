"""What a walking controller sees and intends, for the eyes of observers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

#: What `Balance.phase` may be.
PHASES = ("stand", "double", "left", "right", "flight")

_NOWHERE = np.full(3, np.nan)


@dataclass(frozen=True, slots=True)
class Footstep:
    """A place for a sole on the ground.

    Attributes:
        side: "left" or "right".
        position: (3,) sole centre in the world, m.
        yaw: heading of the sole about world z, rad.
    """

    side: str
    position: np.ndarray
    yaw: float


@dataclass(frozen=True, slots=True)
class Balance:
    """How the balance is after a tick, in world axes. NaN: not known.

    Attributes:
        com: (3,) centre of mass, m.
        dcm: (3,) divergent component of motion c + ċ/ω, on the ground, m.
        dcm_reference: (3,) where the plan wants it, on the ground, m.
        zmp: (3,) commanded zero-moment point, on the ground, m.
        phase: one of `PHASES`; "left" and "right" name the foot that carries.
    """

    com: np.ndarray = field(default_factory=lambda: _NOWHERE)
    dcm: np.ndarray = field(default_factory=lambda: _NOWHERE)
    dcm_reference: np.ndarray = field(default_factory=lambda: _NOWHERE)
    zmp: np.ndarray = field(default_factory=lambda: _NOWHERE)
    phase: str = "stand"


@dataclass(frozen=True, slots=True)
class Telemetry(Balance):
    """Balance and gait quantities after a tick, in world axes. NaN: not known.

    Attributes:
        com: (3,) centre of mass, m.
        dcm: (3,) divergent component of motion c + ċ/ω, on the ground, m.
        dcm_reference: (3,) where the plan wants it, on the ground, m.
        zmp: (3,) commanded zero-moment point, on the ground, m.
        phase: one of `PHASES`; "left" and "right" name the foot that carries.
        support: (k, 3) vertices of the support polygon, counter-clockwise, m.
        footsteps: planned steps, the next one first.
        swing_path: (m, 3) way of the swing sole's centre still to go, m.
    """

    support: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    footsteps: tuple[Footstep, ...] = ()
    swing_path: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
