"""The memory of all groups: three arrays, which a kernel gets as they are.

Unpacking seventy arrays costs a compiled function more than ten microseconds a call, these three
a tenth of one. The compiled `read_…` functions find the groups again on the other side; they are
generated from the groups' declarations.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from wbc.jit.compile import subkernel
from wbc.qp.kernels import groups
from wbc.qp.kernels.schema import ArrayField, Sizes, fields_of

_GROUPS: tuple[type, ...] = (
    groups.Tree,
    groups.Frames,
    groups.MotionTasks,
    groups.JointTasks,
    groups.Contacts,
    groups.DenseRows,
    groups.JointBounds,
    groups.Inequalities,
    groups.AffineMaps,
    groups.QuadraticProgram,
)
_MAX_AXES = 3


class Buffers:
    """All groups of one structure of the QP, as views of three arrays.

    Args:
        sizes: lengths of all axes.

    Attributes:
        arrays: the reals, the integers, and one line per array that tells where it begins and how
            long its axes are.
    """

    def __init__(self, sizes: Sizes) -> None:
        lines = []
        length: dict[type, int] = {np.float64: 0, np.int64: 0}
        for group in _GROUPS:
            for field in fields_of(group):
                shape = sizes.shape(field)
                lines.append((length[field.dtype], *shape, *(1,) * (_MAX_AXES - len(shape))))
                length[field.dtype] += math.prod(shape)
        memory: dict[type, np.ndarray] = {
            dtype: np.zeros(size, dtype) for dtype, size in length.items()
        }
        self.arrays = (memory[np.float64], memory[np.int64], np.array(lines, dtype=np.int64))
        starts = iter(line[0] for line in lines)

        def view(field: ArrayField) -> np.ndarray:
            shape, start = sizes.shape(field), next(starts)
            return memory[field.dtype][start : start + math.prod(shape)].reshape(shape)

        made: dict[type, Any] = {
            group: group(*(view(field) for field in fields_of(group))) for group in _GROUPS
        }
        self.tree: groups.Tree = made[groups.Tree]
        self.frames: groups.Frames = made[groups.Frames]
        self.motion_tasks: groups.MotionTasks = made[groups.MotionTasks]
        self.joint_tasks: groups.JointTasks = made[groups.JointTasks]
        self.contacts: groups.Contacts = made[groups.Contacts]
        self.rows: groups.DenseRows = made[groups.DenseRows]
        self.bounds: groups.JointBounds = made[groups.JointBounds]
        self.inequalities: groups.Inequalities = made[groups.Inequalities]
        self.maps: groups.AffineMaps = made[groups.AffineMaps]
        self.program: groups.QuadraticProgram = made[groups.QuadraticProgram]


# A line of the table, not its number: Numba would compile these anew for each number.
@subkernel
def _one_axis(flat: np.ndarray, line: np.ndarray) -> np.ndarray:
    return flat[line[0] : line[0] + line[1]]


@subkernel
def _two_axes(flat: np.ndarray, line: np.ndarray) -> np.ndarray:
    return flat[line[0] : line[0] + line[1] * line[2]].reshape(line[1], line[2])


@subkernel
def _three_axes(flat: np.ndarray, line: np.ndarray) -> np.ndarray:
    size = line[1] * line[2] * line[3]
    return flat[line[0] : line[0] + size].reshape(line[1], line[2], line[3])


def _reader(group: type) -> Callable[[np.ndarray, np.ndarray, np.ndarray], Any]:
    """Return the compiled function that finds a group in the three arrays."""
    first = sum(len(fields_of(other)) for other in _GROUPS[: _GROUPS.index(group)])
    views = ("_one_axis", "_two_axes", "_three_axes")
    arguments = ", ".join(
        f"{views[len(field.axes) - 1]}({'reals' if field.dtype is np.float64 else 'integers'}, "
        f"table[{first + k}])"
        for k, field in enumerate(fields_of(group))
    )
    source = f"def read(reals, integers, table):\n    return Group({arguments})\n"
    namespace = {**globals(), "Group": group}
    exec(source, namespace)
    read: Callable[[np.ndarray, np.ndarray, np.ndarray], Any] = subkernel(namespace["read"])
    return read


read_tree = _reader(groups.Tree)
read_frames = _reader(groups.Frames)
read_motion_tasks = _reader(groups.MotionTasks)
read_joint_tasks = _reader(groups.JointTasks)
read_contacts = _reader(groups.Contacts)
read_rows = _reader(groups.DenseRows)
read_bounds = _reader(groups.JointBounds)
read_inequalities = _reader(groups.Inequalities)
read_maps = _reader(groups.AffineMaps)
read_program = _reader(groups.QuadraticProgram)
