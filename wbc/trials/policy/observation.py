"""What a policy observes: terms, their scales and their history."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wbc.errors import did_you_mean
from wbc.trials.policy.errors import PolicyError


@dataclass(frozen=True, slots=True)
class PolicyInputs:
    """What the terms of an observation are computed from, at one evaluation of the network.

    Attributes:
        base_velocity: (6,) velocity of the base in its axes: linear, m/s, then angular, rad/s.
        quaternion: (4,) orientation of the base: x, y, z, w.
        command: (3,) wanted velocity: forward and left, m/s, turn, rad/s.
        position: (m,) joint positions in the network's order, rad.
        velocity: (m,) joint velocities in the network's order, rad/s.
        default: (m,) default joint positions in the network's order, rad.
        action: (m,) last output of the network.
        time: time since the reset, s.
    """

    base_velocity: np.ndarray
    quaternion: np.ndarray
    command: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    default: np.ndarray
    action: np.ndarray
    time: float


def projected_gravity(quaternion: np.ndarray) -> np.ndarray:
    """Return the direction of gravity in the axes of the base, `Rᵀ (0, 0, −1)`, (3,).

    Args:
        quaternion: (4,) orientation of the base, unit length: x, y, z, w.
    """
    x, y, z, w = quaternion.tolist()
    return np.array(
        (2.0 * (w * y - x * z), -2.0 * (y * z + w * x), 2.0 * (x * x + y * y) - 1.0),
    )


#: Term, as IsaacLab names it -> its value.
_VALUES: Mapping[str, Callable[[PolicyInputs], np.ndarray]] = {
    "base_lin_vel": lambda inputs: inputs.base_velocity[:3],
    "base_ang_vel": lambda inputs: inputs.base_velocity[3:],
    "projected_gravity": lambda inputs: projected_gravity(inputs.quaternion),
    "velocity_commands": lambda inputs: inputs.command,
    "joint_pos": lambda inputs: inputs.position,
    "joint_pos_rel": lambda inputs: inputs.position - inputs.default,
    "joint_vel": lambda inputs: inputs.velocity,
    "joint_vel_rel": lambda inputs: inputs.velocity,
    "last_action": lambda inputs: inputs.action,
}
_GAIT_PHASE = "gait_phase"
_JOINT_TERMS = ("joint_pos", "joint_pos_rel", "joint_vel", "joint_vel_rel", "last_action")


@dataclass(frozen=True, slots=True)
class ObservationTerm:
    """One term of an observation: `scale · clip(value)` of the last evaluations, oldest first.

    Attributes:
        name: one of `TERM_NAMES`.
        scale: factor of each entry, one number for all of them or one for each.
        clip: smallest and largest entry before scaling, or None.
        history: number of evaluations, the present one included.
        period: period of the gait phase, s; of the term `gait_phase` only.
    """

    name: str
    scale: tuple[float, ...] = (1.0,)
    clip: tuple[float, float] | None = None
    history: int = 1
    period: float = 0.0

    def __post_init__(self) -> None:
        if self.name not in TERM_NAMES:
            raise PolicyError(
                f"unknown observation '{self.name}'{did_you_mean(self.name, TERM_NAMES)}"
            )
        if self.history < 1:
            raise PolicyError(
                f"observation '{self.name}' has a history of {self.history} evaluations; it "
                "counts the present one, so it is at least 1"
            )
        if self.name == _GAIT_PHASE and not self.period > 0.0:
            raise PolicyError(
                f"observation '{self.name}' has a period of {self.period} s; it must be positive"
            )

    def value(self, inputs: PolicyInputs) -> np.ndarray:
        """Return the term's value now, clipped and scaled, (k,)."""
        if self.name == _GAIT_PHASE:
            angle = 2.0 * math.pi * inputs.time / self.period
            value = np.array((math.sin(angle), math.cos(angle)))
        else:
            value = _VALUES[self.name](inputs)
        if self.clip is not None:
            value = np.clip(value, *self.clip)
        return value * self.scale

    def size(self, joints: int) -> int:
        """Return the number of entries of one evaluation, for a number of joints."""
        return joints if self.name in _JOINT_TERMS else 2 if self.name == _GAIT_PHASE else 3


#: Observations that a description may name.
TERM_NAMES = (*_VALUES, _GAIT_PHASE)


class ObservationHistory:
    """Collects the terms' last values and lays them out as the network's input.

    The layout is IsaacLab's: term after term, and of each term its values from the oldest to the
    newest. Before there are enough of them, the first one stands in for those that are missing.

    Args:
        terms: terms in the order of the input.
        joints: number of joints of the network.

    Attributes:
        size: number of entries of the network's input.
    """

    def __init__(self, terms: Sequence[ObservationTerm], joints: int) -> None:
        self._terms = tuple(terms)
        shapes = [(term.history, term.size(joints)) for term in self._terms]
        ends = np.cumsum([rows * columns for rows, columns in shapes], dtype=int)
        self.size = int(ends[-1]) if shapes else 0
        self._values = np.zeros(self.size, dtype=np.float32)
        self._shapes, self._ends = shapes, ends.tolist()
        self._empty = True

    def clear(self) -> None:
        """Forget all values."""
        self._empty = True

    def update(self, inputs: PolicyInputs) -> np.ndarray:
        """Return the network's input (size,) with the values of now as the newest."""
        for term, (rows, columns), end in zip(self._terms, self._shapes, self._ends, strict=True):
            block = self._values[end - rows * columns : end].reshape(rows, columns)
            if self._empty:
                block[:] = term.value(inputs)
            else:
                block[:-1] = block[1:]
                block[-1] = term.value(inputs)
        self._empty = False
        return self._values
