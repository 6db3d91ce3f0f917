"""The declaration of the kernels' arrays: what a group's fields are, and how long.

A group is a `NamedTuple` whose fields are annotated with `reals(…)` or `integers(…)`, the lengths
of the axes by their names in `Sizes`. From that follow the memory (`wbc.qp.kernels.buffers`) and
the compiled function that finds a group in it: a new array is one line in one group.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, get_type_hints

import numpy as np


@dataclass(frozen=True)
class ArrayField:
    """Type and shape of one array.

    Attributes:
        dtype: float or int64.
        axes: length of each axis, a number or the name of one in `Sizes`; one to three.
    """

    dtype: type
    axes: tuple[str | int, ...]


def reals(*axes: str | int) -> ArrayField:
    """Return the field of an array of floats."""
    return ArrayField(np.float64, axes)


def integers(*axes: str | int) -> ArrayField:
    """Return the field of an array of whole numbers."""
    return ArrayField(np.int64, axes)


def fields_of(group: type) -> tuple[ArrayField, ...]:
    """Return the fields of a group in their order."""
    hints: dict[str, Any] = get_type_hints(group, include_extras=True)
    return tuple(hint.__metadata__[0] for hint in hints.values())


@dataclass(frozen=True)
class Sizes:
    """The lengths of all axes, for one structure of the QP.

    Attributes:
        joints: actuated joints, na.
        forces: contact force components, nf.
        unknowns: of the QP, n.
        frames: frames that tasks and contacts refer to, the centroid among them.
        motion_tasks: tasks on components of a frame's motion.
        joint_rows: rows of weighted tasks on single joints.
        contacts: contacts.
        cone_rows: rows of all contacts' force cones.
        dense_rows: rows of dense tasks and of contacts that are not eliminated.
        cost_rows: how many of them are in the cost.
        residual_rows: rows of the cost's residual, a multiple of three.
        bounds: limits on joint accelerations.
        limited_torques: joints whose torque is limited.
        limit_rows: rows of general limits.
        stance_joints: joints that move the eliminated contact.
        dense_columns: columns of the base's map that may differ from zero.
        constraint_rows: rows of C.
    """

    joints: int
    forces: int
    unknowns: int
    frames: int
    motion_tasks: int
    joint_rows: int
    contacts: int
    cone_rows: int
    dense_rows: int
    cost_rows: int
    residual_rows: int
    bounds: int
    limited_torques: int
    limit_rows: int
    stance_joints: int
    dense_columns: int
    constraint_rows: int

    @cached_property
    def bodies(self) -> int:
        """The base and one body per joint."""
        return self.joints + 1

    @cached_property
    def velocities(self) -> int:
        """Size of the generalised velocity, nv."""
        return self.joints + 6

    @cached_property
    def affine(self) -> int:
        """Size of x̂ = (x, 1)."""
        return self.unknowns + 1

    @cached_property
    def bound_rows(self) -> int:
        """Size of lb and ub."""
        return self.joints + self.constraint_rows

    def shape(self, field: ArrayField) -> tuple[int, ...]:
        """Return the shape of an array."""
        return tuple(
            axis if isinstance(axis, int) else int(getattr(self, axis)) for axis in field.axes
        )
