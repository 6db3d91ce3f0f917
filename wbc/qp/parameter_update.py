"""Fetches what tasks, contacts and limits want into the kernels' arrays, tick by tick.

One function per kind of thing: it is told where the thing's numbers go, once, and returns a
function that fetches them. Gains are copied only when they were set anew.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wbc.contacts import Contact
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.qp.kernels.store import Store
from wbc.tasks import JointTask, MotionTask, PostureTask, Task, TaskReference

_ACCELERATIONS, _POSITIONS, _VELOCITIES = 0, 1, 2  # kinds of limits, see `groups.Limits`

Gather = Callable[[Kinematics], None]


def inherits(thing: object, owner: type, method: str) -> bool:
    """Whether a method is the library's own, which the kernels know."""
    return isinstance(thing, owner) and getattr(type(thing), method) is getattr(owner, method)


def knows_motion(task: Task) -> bool:
    """Whether the kernels write this task's rows; otherwise it writes them itself."""
    return inherits(task, MotionTask, "write")


def knows_contact(contact: Contact) -> bool:
    """Whether the kernels write this contact's rows; otherwise it writes them itself."""
    return inherits(contact, Contact, "write")


def motion_gather(task: MotionTask, store: Store, k: int, frame: int, row: int) -> Gather:
    """The k-th task on a motion."""
    group, rows = store.tasks, task.components
    group.place[k] = (frame, rows.start, task.size, row)
    group.target[k] = np.eye(4)
    reference = TaskReference(group.target[k], group.reference[k])
    kp, kd = group.gain[k, :6][rows], group.gain[k, 6:][rows]
    root = store.rows.root[row : row + task.size]
    gains: object = None

    def gather(kin: Kinematics) -> None:
        nonlocal gains
        task.write_reference(kin, reference)
        if gains is not task.gains:
            gains = task.gains
            kp[:], kd[:] = task.kp, task.kd
            root[:] = task.sqrt_weight

    return gather


def rows_gather(task: Task, store: Store, row: int) -> Gather:
    """A task that writes its rows itself."""
    stacked, rows = store.rows, slice(row, row + task.size)
    A, b, root = stacked.A[rows], stacked.b[rows], stacked.root[rows]

    def gather(kin: Kinematics) -> None:
        task.write(kin, A, b)
        root[:] = task.sqrt_weight

    return gather


def wish_gather(task: JointTask, store: Store, rows: slice) -> Gather:
    """A weighted task on single joints."""
    wishes = store.wishes
    wishes.joint[rows] = task.index
    velocity, acceleration = wishes.reference[0, rows], wishes.reference[1, rows]
    kp, kd, weight = (gain[rows] for gain in wishes.gain)
    target = wishes.target[rows]
    gains: object = None
    if not (isinstance(task, PostureTask) and inherits(task, PostureTask, "write_joints")):

        def gather_written(kin: Kinematics) -> None:
            task.write_joints(kin, acceleration)
            weight[:] = task.weight

        return gather_written
    posture = task

    def gather(kin: Kinematics) -> None:
        nonlocal gains
        target[:] = posture.target
        velocity[:] = posture.velocity
        acceleration[:] = posture.acceleration
        if gains is not posture.gains:
            gains = posture.gains
            kp[:], kd[:], weight[:] = posture.kp, posture.kd, posture.weight

    return gather


def contact_gather(
    contact: Contact, store: Store, k: int, frame: int, rows: slice, row: int
) -> Gather:
    """The k-th contact."""
    group = store.contacts
    group.place[k] = (frame, rows.start, contact.motion_size, row, contact.cone.shape[0])
    cone, number = group.cone[k], group.number[k]
    J, a = group.J[rows], group.a[rows]
    root = store.rows.root[row : row + contact.motion_size]
    soft = contact.motion_weight is not None
    written = not knows_contact(contact)
    seen: np.ndarray | None = None

    def gather(kin: Kinematics) -> None:
        nonlocal seen
        number[0], number[1] = contact.damping, contact.min_force
        number[2] = contact.max_force
        if contact.cone is not seen:
            seen = contact.cone
            cone[: seen.shape[0], : seen.shape[1]] = seen
        if soft:
            root[:] = (contact.motion_weight or 0.0) ** 0.5
        if written:
            contact.write(kin, J, a)

    return gather


def bound_gather(bound: AccelerationBound, store: Store, k: int) -> Gather:
    """The k-th limit on accelerations."""
    limits = store.limits
    number, (lower, upper, braking) = limits.number[k], limits.joint[k]
    number[:] = 1.0
    if isinstance(bound, JointPositionLimit) and inherits(bound, JointPositionLimit, "bounds"):
        limits.kind[k] = _POSITIONS
        position = bound

        def gather_positions(kin: Kinematics) -> None:
            number[0], number[1] = position.horizon, position.recovery
            fetch_lower(position.lower)
            fetch_upper(position.upper)
            fetch_braking(position.braking)

        fetch_lower, fetch_upper, fetch_braking = map(_fetch, (lower, upper, braking))
        return gather_positions
    if isinstance(bound, JointVelocityLimit) and inherits(bound, JointVelocityLimit, "bounds"):
        limits.kind[k] = _VELOCITIES
        velocity = bound

        def gather_velocities(kin: Kinematics) -> None:
            number[0] = velocity.horizon
            fetch_upper(velocity.maximum)
            fetch_braking(velocity.braking)

        fetch_upper, fetch_braking = map(_fetch, (upper, braking))
        return gather_velocities
    limits.kind[k] = _ACCELERATIONS

    def gather(kin: Kinematics) -> None:
        lower[:], upper[:] = bound.bounds(kin)

    return gather


def torque_gather(limit: TorqueLimit, store: Store) -> Gather:
    """The limit on torques."""
    fetch = _fetch(store.limits.torque)

    def gather(kin: Kinematics) -> None:
        fetch(limit.maximum)

    return gather


def _fetch(to: np.ndarray) -> Callable[[np.ndarray], None]:
    """Copies an array, but one that cannot change only once."""
    seen: np.ndarray | None = None

    def fetch(array: np.ndarray) -> None:
        nonlocal seen
        if array is not seen or array.flags.writeable:
            to[:] = seen = array

    return fetch
