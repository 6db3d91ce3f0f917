"""Errors that name whose rows could not be written, or are not finite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
import pinocchio as pin

from wbc.contacts import Contact
from wbc.errors import ContactError, LimitError, TaskError, WbcError
from wbc.kinematics import Kinematics
from wbc.limits import AccelerationBound, Limit, LimitRows, LimitSet
from wbc.tasks import JointTask, Task


def write_rows(owner: Task | Contact | Limit, kin: Kinematics, *out: Any) -> None:
    """Call `owner.write`, with an error that names the owner.

    Raises:
        TaskError: a task's attribute has a wrong shape or type.
        ContactError: a contact's attribute has.
        LimitError: a limit's attribute has.
    """
    try:
        owner.write(kin, *out)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(owner, error)


def write_joint_rows(task: JointTask, kin: Kinematics, b: np.ndarray) -> None:
    """Call `task.write_joints`, with an error that names the task.

    Raises:
        TaskError: one of its attributes has a wrong shape or type.
    """
    try:
        task.write_joints(kin, b)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(task, error)


def write_bounds(
    bound: AccelerationBound, kin: Kinematics, lower: np.ndarray, upper: np.ndarray
) -> None:
    """Copy what `bound.bounds` returns, with an error that names the limit.

    Raises:
        LimitError: one of its attributes has a wrong shape or type.
    """
    try:
        lower[:], upper[:] = bound.bounds(kin)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(bound, error)


def raise_row_error(owner: object, error: Exception) -> NoReturn:
    """Raise the error that names whose rows could not be written.

    Raises:
        WbcError: the error itself, when it is one of this library and names its cause already.
        TaskError: it was a task.
        ContactError: it was a contact.
        LimitError: it was a limit.
    """
    if isinstance(error, WbcError):
        raise error
    if isinstance(owner, Contact):
        text = f"contact '{owner.name}' cannot write its rows: {error}"
        raise ContactError(text) from error
    if not isinstance(owner, Task):
        name = getattr(owner, "name", type(owner).__name__)
        raise LimitError(f"{name} cannot write its bounds: {error}") from error
    raise TaskError(
        f"task '{owner.name}' cannot write its rows: {error}; "
        f"look at what was set of it last: {_shapes(owner)}"
    ) from error


def _shapes(owner: object) -> str:
    texts = []
    for name, value in vars(owner).items():
        if isinstance(value, np.ndarray) and not name.startswith("_"):
            texts.append(f"{name} {value.shape}")
        elif name in ("target", "velocity", "acceleration", "rate"):
            texts.append(f"{name} {type(value).__name__}")
    return ", ".join(texts)


def non_finite_rows(
    kin: Kinematics, tasks: Sequence[Task], contacts: Sequence[Contact], limits: LimitSet
) -> str:
    """Return whose rows are not finite and which of its attributes; empty when all are finite."""
    nv, na = kin.model.nv, kin.model.nv - 6
    for task in tasks:
        A, b = np.zeros((task.size, nv)), np.zeros(task.size)
        write_rows(task, kin, A, b)
        if not (np.isfinite(A).all() and np.isfinite(b).all()):
            return f"the rows of task '{task.name}' are not finite{_culprits(task)}"
    for contact in contacts:
        J, a = np.zeros((contact.motion_size, nv)), np.zeros(contact.motion_size)
        write_rows(contact, kin, J, a)
        numbers = (contact.min_force, contact.max_force, contact.motion_weight or 1.0)
        if not np.isfinite(a).all() or any(np.isnan(x) or x < 0.0 for x in numbers):
            return f"the rows of contact '{contact.name}' are not finite{_culprits(contact)}"
    for bound in limits.bounds:
        lower, upper = np.zeros(na), np.zeros(na)
        write_bounds(bound, kin, lower, upper)
        if np.isnan(lower).any() or np.isnan(upper).any():
            return f"the bounds of the {bound.name} are not numbers{_culprits(bound)}"
    for limit in limits.inequalities:
        forces = {c: np.zeros((limit.size, c.motion_size)) for c in contacts}
        rows = LimitRows(
            np.zeros((limit.size, nv)), np.zeros(limit.size), np.zeros(limit.size), forces
        )
        rows.clear()
        write_rows(limit, kin, rows)
        finite = all(np.isfinite(x).all() for x in (rows.A, *forces.values()))
        if not finite or np.isnan(rows.lower).any() or np.isnan(rows.upper).any():
            return f"the rows of limit '{limit.name}' are not finite{_culprits(limit)}"
    return ""


def _culprits(owner: object) -> str:
    texts = []
    for name, value in vars(owner).items():
        array = value.homogeneous if isinstance(value, pin.SE3) else value
        if isinstance(array, (np.ndarray, float)) and not np.isfinite(array).all():
            text = " ".join(np.array2string(np.asarray(array), precision=3).split())
            texts.append(f"{name.lstrip('_')} = {text}")
    return f": {', '.join(texts)}" if texts else ""
