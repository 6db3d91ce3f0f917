"""Lets tasks and contacts write their rows, and says whose they were when that fails."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

import numpy as np
import pinocchio as pin

from wbc.contacts import Contact
from wbc.errors import ContactError, LimitError, TaskError
from wbc.kinematics import Kinematics
from wbc.tasks import JointTask, Task


def write_task(task: Task, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
    """`task.write`, with an error that names the task.

    Raises:
        TaskError: one of its attributes has a wrong shape or type.
    """
    try:
        task.write(kin, A, b)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(task, error)


def write_joint_task(task: JointTask, kin: Kinematics, b: np.ndarray) -> None:
    """`task.write_joints`, with an error that names the task.

    Raises:
        TaskError: one of its attributes has a wrong shape or type.
    """
    try:
        task.write_joints(kin, b)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(task, error)


def write_contact(contact: Contact, kin: Kinematics, J: np.ndarray, a: np.ndarray) -> None:
    """`contact.write`, with an error that names the contact.

    Raises:
        ContactError: one of its attributes has a wrong shape or type.
    """
    try:
        contact.write(kin, J, a)
    except (ValueError, TypeError, AttributeError) as error:
        raise_row_error(contact, error)


def raise_row_error(owner: object, error: Exception) -> NoReturn:
    """Raise the error that names whose rows could not be had.

    Raises:
        TaskError: it was a task.
        ContactError: it was a contact.
        LimitError: it was a limit.
    """
    if isinstance(owner, Contact):
        text = f"contact '{owner.name}' cannot state its rows: {error}"
        raise ContactError(text) from error
    if not isinstance(owner, Task):
        name = getattr(owner, "name", type(owner).__name__)
        raise LimitError(f"{name} cannot state its bounds: {error}") from error
    raise TaskError(
        f"task '{owner.name}' cannot state its rows: {error}; "
        f"look at what was set of it last: {_shapes(owner)}"
    ) from error


def _shapes(thing: object) -> str:
    texts = []
    for name, value in vars(thing).items():
        if isinstance(value, np.ndarray) and not name.startswith("_"):
            texts.append(f"{name} {value.shape}")
        elif name in ("target", "velocity", "acceleration", "rate"):
            texts.append(f"{name} {type(value).__name__}")
    return ", ".join(texts)


def non_finite_rows(kin: Kinematics, tasks: Sequence[Task], contacts: Sequence[Contact]) -> str:
    """Whose rows are not finite, and which of its attributes; empty when all are finite."""
    nv = kin.model.nv
    for task in tasks:
        A, b = np.zeros((task.size, nv)), np.zeros(task.size)
        write_task(task, kin, A, b)
        if not (np.isfinite(A).all() and np.isfinite(b).all()):
            return f"the rows of task '{task.name}' are not finite{_culprits(task)}"
    for contact in contacts:
        J, a = np.zeros((contact.motion_size, nv)), np.zeros(contact.motion_size)
        write_contact(contact, kin, J, a)
        limits = (contact.min_force, contact.max_force, contact.motion_weight or 1.0)
        if not np.isfinite(a).all() or any(np.isnan(x) or x < 0.0 for x in limits):
            return f"contact '{contact.name}' makes no sense{_culprits(contact)}"
    return ""


def _culprits(thing: object) -> str:
    texts = []
    for name, value in vars(thing).items():
        array = value.homogeneous if isinstance(value, pin.SE3) else value
        if isinstance(array, (np.ndarray, float)) and not np.isfinite(array).all():
            texts.append(f"{name.lstrip('_')} = {np.array2string(np.asarray(array), precision=3)}")
    return f": {', '.join(texts)}" if texts else ""
