"""Rows of tasks, contacts and limits."""

from __future__ import annotations

import math

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels.groups import Contacts, DenseRows, Frames, JointBounds, MotionTasks
from wbc.qp.kernels.motion import log3

ACCELERATIONS, POSITIONS, VELOCITIES = 0, 1, 2  #: kinds of `JointBounds`


@subkernel
def write_tasks(tasks: MotionTasks, frames: Frames, rows: DenseRows) -> None:
    """Write `A v̇ = b` of the tasks, see `wbc.tasks.motion.MotionTask`."""
    error = np.empty(6)
    for t in range(tasks.frame.size):
        k, first, size, row = tasks.frame[t], tasks.component[t], tasks.size[t], tasks.row[t]
        placement, target = frames.placement[k], tasks.target[t]
        for i in range(3):
            error[i] = target[i, 3] - placement[i, 3]
        if k > 0 and first + size > 3:
            log3(target, placement, error[3:])
        elif k == 0:
            for i in range(3):
                error[3 + i] = target[i, 3] - frames.velocity[0, 3 + i]
        for i in range(size):
            c = first + i
            rows.b[row + i] = (
                tasks.acceleration[t, c]
                + tasks.kd[t, c] * (tasks.velocity[t, c] - frames.velocity[k, c])
                + tasks.kp[t, c] * error[c]
                - frames.bias[k, c]
            )
            for j in range(rows.A.shape[1]):
                rows.A[row + i, j] = frames.jacobian[k, c, j]


@subkernel
def write_contacts(contacts: Contacts, frames: Frames, rows: DenseRows) -> None:
    """Write `J v̇ = a` of the contacts in their axes; copy it to the rows unless eliminated."""
    J, a = contacts.jacobian, contacts.acceleration
    for i in range(contacts.frame.size):
        k, start, size, row = (
            contacts.frame[i],
            contacts.force[i],
            contacts.size[i],
            contacts.row[i],
        )
        if k > 0:
            R, motion = frames.placement[k], frames.jacobian[k]
            damping = contacts.damping[i]
            for m in range(size):
                half, axis = 3 * (m // 3), m % 3  # linear or angular
                r0, r1, r2 = R[0, axis], R[1, axis], R[2, axis]
                out = J[start + m]
                for c in range(out.size):
                    out[c] = (
                        r0 * motion[half, c] + r1 * motion[half + 1, c] + r2 * motion[half + 2, c]
                    )
                s = 0.0
                for j in range(3):
                    damped = -damping * frames.velocity[k, half + j]
                    s += R[j, axis] * (damped - frames.bias[k, half + j])
                a[start + m] = s
        if row >= 0:
            for m in range(size):
                rows.b[row + m] = a[start + m]
                for c in range(rows.A.shape[1]):
                    rows.A[row + m, c] = J[start + m, c]


@subkernel
def write_joint_bounds(
    bounds: JointBounds, q: np.ndarray, v: np.ndarray, lb: np.ndarray, ub: np.ndarray
) -> None:
    """Write the tightest bounds of all limits; where two exclude each other the first holds."""
    for j in range(lb.size):
        low, high = -np.inf, np.inf
        position, velocity = q[7 + j], v[6 + j]
        for i in range(bounds.kind.size):
            lower, upper, braking = bounds.lower[i, j], bounds.upper[i, j], bounds.braking[i, j]
            horizon, recovery = bounds.horizon[i], bounds.recovery[i]
            if bounds.kind[i] == POSITIONS:
                least = -max_acceleration_towards_limit(
                    position - lower, -velocity, braking, horizon, recovery
                )
                most = max_acceleration_towards_limit(
                    upper - position, velocity, braking, horizon, recovery
                )
            elif bounds.kind[i] == VELOCITIES:
                least = min((-upper - velocity) / horizon, braking)
                most = max((upper - velocity) / horizon, -braking)
            else:
                least, most = lower, upper
            low, high = min(max(least, low), high), min(max(most, low), high)
        lb[j], ub[j] = low, high


@subkernel
def max_acceleration_towards_limit(
    distance: float, velocity: float, braking: float, horizon: float, recovery: float
) -> float:
    """Return the largest acceleration towards one of a joint's two position limits.

    The law is that of `wbc.limits.JointPositionLimit`.
    """
    rate = 0.5 / horizon
    knee = braking / rate
    if distance < 0.0:
        slope = 1.0 / recovery
        speed = distance * slope
    elif distance * rate < knee:
        slope = rate
        speed = distance * slope
    else:
        speed = math.sqrt(2.0 * braking * distance - knee * knee)
        slope = braking / speed
    return max(rate * (speed - velocity) - slope * velocity, -braking)
