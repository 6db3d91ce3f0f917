"""Copies what tasks, contacts and limits ask for into the kernels' buffers, tick by tick.

One function per kind: it looks up once where an object's numbers go, and returns a function that
copies them in each tick and the arrays that it writes. Gains are copied only when they were set
anew.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from wbc.contacts import Contact
from wbc.errors import ContactError
from wbc.kinematics import Kinematics
from wbc.limits import (
    AccelerationBound,
    JointPositionLimit,
    JointVelocityLimit,
    Limit,
    LimitRows,
    TorqueLimit,
)
from wbc.qp.kernels.buffers import Buffers
from wbc.qp.kernels.rows import ACCELERATIONS, POSITIONS, VELOCITIES
from wbc.tasks import JointTask, MotionTask, PostureTask, Task, TaskReference

Update = Callable[[Kinematics], None]
#: An update, and the arrays that it writes.
UpdateAndWritten = tuple[Update, tuple[np.ndarray, ...]]


def inherits(instance: object, owner: type, method: str) -> bool:
    """Return whether a method is the library's own, which the kernels implement."""
    return isinstance(instance, owner) and getattr(type(instance), method) is getattr(owner, method)


def has_motion_kernel(task: Task) -> bool:
    """Return whether the kernels write this task's rows; otherwise it writes them itself."""
    return inherits(task, MotionTask, "write")


def has_contact_kernel(contact: Contact) -> bool:
    """Return whether the kernels write this contact's rows; otherwise it writes them itself."""
    return inherits(contact, Contact, "write")


def motion_task_update(
    task: MotionTask, buffers: Buffers, k: int, frame: int, row: int
) -> UpdateAndWritten:
    """Update of the k-th motion task, whose rows start at `row` of the dense ones."""
    group, part = buffers.motion_tasks, task.components
    group.frame[k], group.component[k] = frame, part.start
    group.size[k], group.row[k] = task.size, row
    group.target[k] = np.eye(4)
    reference = TaskReference(group.target[k], group.velocity[k, part], group.acceleration[k, part])
    kp, kd = group.kp[k, part], group.kd[k, part]
    root_weight = buffers.rows.root_weight[row : row + task.size]
    gains: object = None

    def update(kin: Kinematics) -> None:
        nonlocal gains
        task.write_reference(kin, reference)
        if gains is not task.gains:
            gains = task.gains
            kp[:], kd[:] = task.kp, task.kd
            root_weight[:] = task.sqrt_weight[: root_weight.size]

    pose = reference.pose[:3]
    return update, (pose, reference.velocity, reference.acceleration, kp, kd, root_weight)


def dense_task_update(task: Task, buffers: Buffers, row: int) -> UpdateAndWritten:
    """Update of a task that writes its rows itself."""
    stacked, part = buffers.rows, slice(row, row + task.size)
    A, b, root_weight = stacked.A[part], stacked.b[part], stacked.root_weight[part]

    def update(kin: Kinematics) -> None:
        task.write(kin, A, b)
        root_weight[:] = task.sqrt_weight[: root_weight.size]

    return update, (A, b, root_weight)


def joint_task_update(task: JointTask, buffers: Buffers, part: slice) -> UpdateAndWritten:
    """Update of a weighted task on single joints."""
    group = buffers.joint_tasks
    group.joint[part] = task.index
    target, velocity, acceleration = (
        group.target[part],
        group.velocity[part],
        group.acceleration[part],
    )
    kp, kd, weight = group.kp[part], group.kd[part], group.weight[part]
    written = (target, velocity, acceleration, kp, kd, weight)
    gains: object = None
    if not (isinstance(task, PostureTask) and inherits(task, PostureTask, "write_joints")):

        def update_written(kin: Kinematics) -> None:
            task.write_joints(kin, acceleration)
            weight[:] = task.weight

        return update_written, written
    posture = task

    def update(kin: Kinematics) -> None:
        nonlocal gains
        target[:] = posture.target
        velocity[:] = posture.velocity
        acceleration[:] = posture.acceleration
        if gains is not posture.gains:
            gains = posture.gains
            kp[:], kd[:], weight[:] = posture.kp, posture.kd, posture.weight

    return update, written


def contact_update(
    contact: Contact, buffers: Buffers, k: int, frame: int, forces: slice, cone_row: int, row: int
) -> UpdateAndWritten:
    """Update of the k-th contact.

    Args:
        contact: the contact.
        buffers: buffers to write to.
        k: its place among the contacts.
        frame: index of its frame.
        forces: its force components.
        cone_row: first row of its cone.
        row: first row of its motion among the dense rows; −1 when it is eliminated.
    """
    group, size = buffers.contacts, contact.cone.shape[0]
    group.frame[k], group.force[k], group.size[k] = frame, forces.start, contact.motion_size
    group.row[k], group.cone_row[k], group.cone_size[k] = row, cone_row, size
    cone = group.cone[cone_row : cone_row + size, : contact.motion_size]
    damping, min_force, max_force = group.damping, group.min_force, group.max_force
    J, a = group.jacobian[forces], group.acceleration[forces]
    root_weight = buffers.rows.root_weight[row : row + contact.motion_size]
    soft = contact.motion_weight is not None
    written = not has_contact_kernel(contact)
    copied: np.ndarray | None = None
    placed: pin.SE3 | None = None
    in_body = buffers.frames.in_body[frame]
    in_joint = pin.SE3(in_body)  # of the contact's frame

    def update(kin: Kinematics) -> None:
        nonlocal copied, placed
        if contact.placement is not placed and not written:
            placed = contact.placement
            in_body[:] = (in_joint * placed).homogeneous
        damping[k] = contact.damping
        min_force[k], max_force[k] = contact.min_force, contact.max_force
        if contact.cone is not copied:
            copied = contact.cone
            if copied.shape != cone.shape:
                raise ContactError(
                    f"contact '{contact.name}': its cone had {cone.shape[0]} rows and has "
                    f"{copied.shape[0]}; their number must not change"
                )
            cone[:] = copied
        if soft:
            root_weight[:] = (contact.motion_weight or 0.0) ** 0.5
        if written:
            contact.write(kin, J, a)

    numbers = (damping[k : k + 1], min_force[k : k + 1], max_force[k : k + 1])
    return update, (*numbers, *([root_weight] if soft else ()), *([J, a] if written else ()))


def bound_update(bound: AccelerationBound, buffers: Buffers, k: int) -> UpdateAndWritten:
    """Update of the k-th limit on joint accelerations."""
    group = buffers.bounds
    lower, upper, braking = group.lower[k], group.upper[k], group.braking[k]
    horizon, recovery = group.horizon, group.recovery
    horizon[k] = recovery[k] = 1.0
    if isinstance(bound, JointPositionLimit) and inherits(bound, JointPositionLimit, "bounds"):
        group.kind[k] = POSITIONS
        position = bound

        def update_positions(kin: Kinematics) -> None:
            horizon[k], recovery[k] = position.horizon, position.recovery
            copy_lower(position.lower)
            copy_upper(position.upper)
            copy_braking(position.braking)

        copy_lower, copy_upper, copy_braking = map(_copier, (lower, upper, braking))
        return update_positions, (horizon[k : k + 1], recovery[k : k + 1], lower, upper, braking)
    if isinstance(bound, JointVelocityLimit) and inherits(bound, JointVelocityLimit, "bounds"):
        group.kind[k] = VELOCITIES
        velocity = bound

        def update_velocities(kin: Kinematics) -> None:
            horizon[k] = velocity.horizon
            copy_upper(velocity.maximum)
            copy_braking(velocity.braking)

        copy_upper, copy_braking = map(_copier, (upper, braking))
        return update_velocities, (horizon[k : k + 1], upper, braking)
    group.kind[k] = ACCELERATIONS

    def update(kin: Kinematics) -> None:
        lower[:], upper[:] = bound.bounds(kin)

    return update, (lower, upper)


def torque_update(limit: TorqueLimit, buffers: Buffers) -> UpdateAndWritten:
    """Update of the limit on torques."""
    copy = _copier(buffers.bounds.torque)

    def update(kin: Kinematics) -> None:
        copy(limit.maximum)

    return update, (buffers.bounds.torque,)


def limit_update(
    limit: Limit, buffers: Buffers, part: slice, forces: dict[Contact, slice]
) -> UpdateAndWritten:
    """Update of a general limit.

    Args:
        limit: the limit.
        buffers: buffers to write to.
        part: its rows among those of the general limits.
        forces: force components of each contact.
    """
    group = buffers.inequalities
    columns = {contact: group.F[part, components] for contact, components in forces.items()}
    rows = LimitRows(group.A[part], group.lower[part], group.upper[part], columns)

    def update(kin: Kinematics) -> None:
        rows.clear()
        limit.write(kin, rows)

    return update, (rows.A, rows.lower, rows.upper, *columns.values())


def _copier(to: np.ndarray) -> Callable[[np.ndarray], None]:
    """Return a function that copies an array, but one that cannot change only once."""
    copied: np.ndarray | None = None

    def copy(array: np.ndarray) -> None:
        nonlocal copied
        if array is not copied or array.flags.writeable:
            to[:] = copied = array

    return copy
