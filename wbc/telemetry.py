"""The telemetry of a controller after a tick: the input of every observer."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

#: Values of `Footstep.side`.
SIDES = ("left", "right", "front_left", "front_right", "hind_left", "hind_right")
#: Values of `Telemetry.phase`; "left" and "right" name the foot that carries the robot,
#: of a quadruped its front foot.
#: "falling": a fall is unavoidable, and the joints only yield.
PHASES = ("stand", "double", "left", "right", "flight", "falling")

_UNKNOWN = np.full(3, np.nan)
_NO_POINTS = np.empty((0, 3))


@dataclass(frozen=True, slots=True)
class Footstep:
    """A place for a sole on the ground.

    Attributes:
        side: one of `SIDES`.
        position: (3,) sole centre in the world, m.
        yaw: heading of the sole about world z, rad.
    """

    side: str
    position: np.ndarray
    yaw: float


@dataclass(frozen=True, slots=True)
class Telemetry:
    """Balance and gait quantities after a tick, in world axes; NaN where a quantity is unknown.

    A controller makes one per tick, so every field is cheap to compute. What costs more is in
    `ContactPlan`.

    Attributes:
        com: (3,) centre of mass, m.
        dcm: (3,) divergent component of motion c + ċ/ω, on the ground, m.
        dcm_reference: (3,) planned DCM, on the ground, m.
        zmp: (3,) commanded zero-moment point, on the ground, m.
        velocity: (3,) commanded walking velocity in the heading frame: forward and left, m/s;
            turn, rad/s.
        heading: mean heading of the soles, rad.
        dcm_error: distance of the DCM from its reference, m.
        phase: one of `PHASES`.
        steps: number of touchdowns since the reset.
        status_text: one short line, e.g. the name of the motion that plays.
    """

    com: np.ndarray = field(default_factory=lambda: _UNKNOWN)
    dcm: np.ndarray = field(default_factory=lambda: _UNKNOWN)
    dcm_reference: np.ndarray = field(default_factory=lambda: _UNKNOWN)
    zmp: np.ndarray = field(default_factory=lambda: _UNKNOWN)
    velocity: np.ndarray = field(default_factory=lambda: _UNKNOWN)
    heading: float = np.nan
    dcm_error: float = np.nan
    phase: str = "stand"
    steps: int = 0
    status_text: str = ""


@dataclass(frozen=True, slots=True)
class ContactPlan:
    """The present support and the planned footsteps, in world axes.

    It takes some 0.1 ms to compute; the loop asks for it 30 times per second.

    Attributes:
        support: (k, 3) vertices of the support polygon, counter-clockwise, m.
        footsteps: planned footsteps, the next one first.
        swing_path: (m, 3) remaining path of the swing sole's centre, m.
    """

    support: np.ndarray = field(default_factory=lambda: _NO_POINTS)
    footsteps: tuple[Footstep, ...] = ()
    swing_path: np.ndarray = field(default_factory=lambda: _NO_POINTS)
