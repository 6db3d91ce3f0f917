"""State and references of one tick, as raw numbers for a process of another environment.

It needs only numpy and the standard library, as `peers.case` does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_FIXED = (
    *(("com", 3), ("com_velocity", 3), ("com_acceleration", 3), ("torso", 9)),
    *(("torso_velocity", 3), ("swing", 16), ("swing_velocity", 6), ("swing_acceleration", 6)),
)
_MATRICES = {"torso": (3, 3), "swing": (4, 4)}


@dataclass(frozen=True)
class Reference:
    """State and references of a tick; see `peers.case.Ticks`.

    Attributes:
        stance: standing feet: `BOTH`, `LEFT` or `RIGHT`.
        leaving: foot that is being unloaded: `LEFT`, `RIGHT`, or `BOTH` for none.
        max_force: largest normal force of the leaving foot, N.
        q: (nq,) configuration.
        v: (nv,) velocity.
        com: (3,) position, m; com_velocity and com_acceleration alike.
        torso: (3, 3) orientation.
        torso_velocity: (3,) rad/s.
        swing: (4, 4) pose of the free foot, T_world_sole.
        swing_velocity: (6,).
        swing_acceleration: (6,).
    """

    stance: int
    leaving: int
    max_force: float
    q: np.ndarray
    v: np.ndarray
    com: np.ndarray
    com_velocity: np.ndarray
    com_acceleration: np.ndarray
    torso: np.ndarray
    torso_velocity: np.ndarray
    swing: np.ndarray
    swing_velocity: np.ndarray
    swing_acceleration: np.ndarray

    @staticmethod
    def size(nv: int) -> int:
        """Return the number of entries of a packed reference."""
        return 3 + (nv + 1) + nv + sum(size for _, size in _FIXED)

    def pack(self) -> np.ndarray:
        """Return all entries in one vector."""
        head = (float(self.stance), float(self.leaving), self.max_force)
        rest = [np.ravel(getattr(self, name)) for name, _ in _FIXED]
        return np.concatenate((head, self.q, self.v, *rest))

    @classmethod
    def unpack(cls, values: np.ndarray, nv: int) -> Reference:
        """Return the reference of a packed vector."""
        stance, leaving, max_force = values[:3].tolist()
        at = 3 + nv + 1
        fields = {"q": values[3:at], "v": values[at : at + nv]}
        at += nv
        for name, size in _FIXED:
            part = values[at : at + size]
            fields[name] = part.reshape(_MATRICES.get(name, (size,)))
            at += size
        return cls(int(stance), int(leaving), max_force, **fields)
