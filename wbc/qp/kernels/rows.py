"""Rows of tasks, contacts and limits."""

from __future__ import annotations

import math

import numpy as np

from wbc.qp.kernels.groups import Contacts, Frames, Limits, Rows, Tasks
from wbc.qp.kernels.jit import part
from wbc.qp.kernels.motion import log3


@part
def write_tasks(tasks: Tasks, frames: Frames, rows: Rows) -> None:
    """`A v̇ = b` of the tasks, see `wbc.tasks.motion.MotionTask`."""
    error = np.empty(6)
    for t in range(tasks.place.shape[0]):
        k, first, size, row = tasks.place[t]
        place, target = frames.placement[k], tasks.target[t]
        for i in range(3):
            error[i] = target[i, 3] - place[i, 3]
        if k > 0 and first + size > 3:
            log3(target, place, error[3:])
        elif k == 0:
            for i in range(3):
                error[3 + i] = target[i, 3] - frames.velocity[0, 3 + i]
        for i in range(size):
            c = first + i
            rows.b[row + i] = (
                tasks.reference[t, 6 + c]
                + tasks.gain[t, 6 + c] * (tasks.reference[t, c] - frames.velocity[k, c])
                + tasks.gain[t, c] * error[c]
                - frames.bias[k, c]
            )
            for j in range(rows.A.shape[1]):
                rows.A[row + i, j] = frames.J[k, c, j]


@part
def write_contacts(contacts: Contacts, frames: Frames, rows: Rows) -> None:
    """`J v̇ = a` of the contacts in their axes; copied to the rows unless eliminated."""
    J, a = contacts.J, contacts.a
    for i in range(contacts.place.shape[0]):
        k, start, size, row = contacts.place[i, :4]
        if k > 0:
            R, motion = frames.placement[k], frames.J[k]
            damping = contacts.number[i, 0]
            for part_of in range(0, size, 3):
                for axis in range(3):
                    r0, r1, r2 = R[0, axis], R[1, axis], R[2, axis]
                    out = J[start + part_of + axis]
                    for c in range(out.size):
                        out[c] = (
                            r0 * motion[part_of, c]
                            + r1 * motion[part_of + 1, c]
                            + r2 * motion[part_of + 2, c]
                        )
                    s = 0.0
                    for m in range(3):
                        wanted = -damping * frames.velocity[k, part_of + m]
                        s += R[m, axis] * (wanted - frames.bias[k, part_of + m])
                    a[start + part_of + axis] = s
        if row >= 0:
            for m in range(size):
                rows.b[row + m] = a[start + m]
                for c in range(rows.A.shape[1]):
                    rows.A[row + m, c] = J[start + m, c]


@part
def bound_joints(
    limits: Limits, q: np.ndarray, v: np.ndarray, lb: np.ndarray, ub: np.ndarray
) -> None:
    """Tightest bounds of all limits; the middle where two exclude each other."""
    for j in range(lb.size):
        low, high = -np.inf, np.inf
        x, rate = q[7 + j], v[6 + j]
        for i in range(limits.kind.size):
            lower, upper = limits.joint[i, 0, j], limits.joint[i, 1, j]
            braking = limits.joint[i, 2, j]
            horizon, recovery = limits.number[i]
            if limits.kind[i] == 1:
                least = -toward(x - lower, -rate, braking, horizon, recovery)
                most = toward(upper - x, rate, braking, horizon, recovery)
            elif limits.kind[i] == 2:
                least = min((-upper - rate) / horizon, braking)
                most = max((upper - rate) / horizon, -braking)
            else:
                least, most = lower, upper
            low, high = max(low, least), min(high, most)
        if low > high:
            low = high = 0.5 * (low + high)
        lb[j], ub[j] = low, high


@part
def toward(distance: float, rate: float, braking: float, horizon: float, recovery: float) -> float:
    """Largest acceleration towards a position limit, see `wbc.limits.JointPositionLimit`."""
    room = 2.0 * max(distance, distance * horizon / recovery) - horizon * rate
    half = 0.5 * horizon * braking
    speed = math.sqrt(max(room, 0.0) * braking + half * half) - half
    return max((speed + min(room, 0.0) / horizon - rate) / horizon, -braking)
