"""The state of a robot: configuration and velocity, in Pinocchio's convention."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.errors import StateError

QUATERNION_TOLERANCE = 1e-3


@dataclass(frozen=True, slots=True)
class State:
    """Configuration and velocity of a floating-base robot.

    Attributes:
        q: (nq,) `[x y z, qx qy qz qw, joints]`; m, unit quaternion, rad.
        v: (nv,) `[base linear, base angular, joints]`, the base twist in the
            base frame; m/s, rad/s.
    """

    q: np.ndarray
    v: np.ndarray

    def checked(self, model: pin.Model) -> State:
        """This state as float arrays, or a `StateError` that names the entry.

        Raises:
            StateError: wrong size, NaN or infinity, or a quaternion that is
                not of unit length.
        """
        q = np.asarray(self.q, dtype=float)
        v = np.asarray(self.v, dtype=float)
        _check_vector("q", q, model.nq)
        _check_vector("v", v, model.nv)
        if _has_free_flyer(model):
            length = float(np.sqrt(q[3:7] @ q[3:7]))
            if abs(length - 1.0) > QUATERNION_TOLERANCE:
                raise StateError(
                    f"state.q[3:7] is a quaternion of length {length:.6g}, not 1; "
                    "normalise it (pin.normalize(model, q)), order x y z w"
                )
        return State(q, v)


def _has_free_flyer(model: pin.Model) -> bool:
    return bool(model.njoints > 1 and model.joints[1].nq == 7)


def _check_vector(name: str, x: np.ndarray, size: int) -> None:
    if x.shape != (size,):
        raise StateError(f"state.{name} has shape {x.shape}, the model needs ({size},)")
    # The sum is one fast reduction: it is finite only if every entry is.
    if not np.isfinite(x.sum()):
        bad = np.flatnonzero(~np.isfinite(x))
        first = int(bad[0]) if bad.size else 0
        raise StateError(
            f"state.{name}[{first}] is {x[first]} ({bad.size} entries are not finite); "
            "a controller needs a finite state"
        )
