"""The state of a robot: configuration and velocity, in Pinocchio's convention."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.errors import StateError
from wbc.formatting import format_vector

QUATERNION_TOLERANCE = 1e-3
_FLOAT = np.dtype(float)
_SHORTEST, _LONGEST = (1.0 - QUATERNION_TOLERANCE) ** 2, (1.0 + QUATERNION_TOLERANCE) ** 2


# Not frozen: every tick makes one, and a frozen one takes three times as long.
@dataclass(slots=True, repr=False)
class State:
    """Configuration and velocity of a floating-base robot.

    Attributes:
        q: (nq,) `[x y z, qx qy qz qw, joints]`; m, unit quaternion, rad.
        v: (nv,) `[base linear, base angular, joints]`, the base twist in the
            base frame; m/s, rad/s.
    """

    q: np.ndarray
    v: np.ndarray

    def __repr__(self) -> str:
        base, joints = format_vector(self.q[:3], "m"), max(len(self.q) - 7, 0)
        fastest = float(np.abs(self.v[6:]).max(initial=0.0))
        return f"State(base at {base}, {joints} joints, the fastest at {fastest:.3g} rad/s)"

    def is_valid(self, nq: int, nv: int) -> bool:
        """Return whether this is a floating-base state that `validated` returns as it is.

        True only for float arrays of these sizes that compiled kernels take (contiguous,
        writeable), finite, with a unit quaternion. When it is False, `validated` converts the
        state or tells what is wrong.
        """
        q, v = self.q, self.v
        if not (type(q) is np.ndarray and type(v) is np.ndarray and nq == nv + 1):
            return False
        if q.shape != (nq,) or v.shape != (nv,) or q.dtype is not _FLOAT or v.dtype is not _FLOAT:
            return False
        if not (q.flags.carray and v.flags.carray):
            return False
        quaternion = q[3:7]
        length = quaternion.dot(quaternion)
        return _SHORTEST < length < _LONGEST and math.isfinite(q.dot(q) + v.dot(v))

    def validated(self, model: pin.Model) -> State:
        """Return this state as contiguous, writeable float arrays, which are copies where needed.

        Raises:
            StateError: wrong size, NaN or infinity, or a quaternion that is
                not of unit length.
        """
        q = _checked_vector("q", self.q, model.nq, model)
        v = _checked_vector("v", self.v, model.nv, model)
        if model.nq > model.nv:  # a floating base: four numbers for three velocities
            quaternion = q[3:7]
            length = math.sqrt(quaternion.dot(quaternion))
            if abs(length - 1.0) > QUATERNION_TOLERANCE:
                raise StateError(
                    f"state.q[3:7] is a quaternion of length {length:.6g}, not 1; "
                    "normalise it (pin.normalize(model, q)), order x y z w"
                )
        return self if q is self.q and v is self.v else State(q, v)


def _checked_vector(name: str, x: np.ndarray, size: int, model: pin.Model) -> np.ndarray:
    x = np.require(x, dtype=float, requirements=("C", "A", "W"))
    if x.shape != (size,):
        raise StateError(f"state.{name} has shape {x.shape}, the model needs ({size},)")
    # One fast reduction: the square is finite only if every entry is (and not absurd).
    if not math.isfinite(x.dot(x)):
        bad = np.flatnonzero(~(np.abs(x) < 1e150))
        first = int(bad[0])
        raise StateError(
            f"state.{name}[{first}] ({_coordinate(model, name, first)}) is {x[first]:g}"
            f"{f', and {bad.size - 1} more entries' if bad.size > 1 else ''}; "
            "a controller needs a finite state: check the estimator or sensor that it comes from"
        )
    return x


def _coordinate(model: pin.Model, name: str, index: int) -> str:
    """Return which joint an entry of q or v belongs to."""
    for joint, text in zip(list(model.joints)[1:], list(model.names)[1:], strict=True):
        start, size = (joint.idx_q, joint.nq) if name == "q" else (joint.idx_v, joint.nv)
        if start <= index < start + size:
            return f"joint '{text}'" if size == 1 else f"joint '{text}', entry {index - start}"
    return "no joint"
