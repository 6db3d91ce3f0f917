"""Arrays that are declared once: allocated in Python, found again in compiled code.

A group is a `NamedTuple` whose fields are annotated with `reals(…)` or `integers(…)`, the lengths
of the axes by their names. From that follow the memory (`Memory`) and the compiled function that
finds a group in it (`reader`): a new array is one line in one group.

Unpacking seventy arrays costs a compiled function more than ten microseconds a call, the three
arrays of a `Memory` a tenth of one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar, get_type_hints

import numpy as np
from numba import carray, types
from numba.extending import intrinsic

from wbc.jit.compile import subkernel

GroupT = TypeVar("GroupT")
_MAX_AXES = 3


@dataclass(frozen=True)
class ArrayField:
    """Type and shape of one array.

    Attributes:
        dtype: float or int64.
        axes: length of each axis, a number or the name of a length; one to three.
    """

    dtype: type
    axes: tuple[str | int, ...]


def reals(*axes: str | int) -> ArrayField:
    """Return the field of an array of floats."""
    return ArrayField(np.float64, axes)


def integers(*axes: str | int) -> ArrayField:
    """Return the field of an array of whole numbers."""
    return ArrayField(np.int64, axes)


@cache
def fields_of(group: type) -> tuple[ArrayField, ...]:
    """Return the fields of a group in their order."""
    hints: dict[str, Any] = get_type_hints(group, include_extras=True)
    return tuple(hint.__metadata__[0] for hint in hints.values())


class Memory:
    """The arrays of some groups, as views of two stretches of memory.

    Args:
        groups: the groups.
        sizes: has the length of each axis under its name.

    Attributes:
        arrays: the reals, the integers, and one line per array that tells where it begins and how
            long its axes are: what a compiled function gets.
    """

    def __init__(self, groups: tuple[type, ...], sizes: object) -> None:
        lines = []
        length: dict[type, int] = {np.float64: 0, np.int64: 0}
        for group in groups:
            for field in fields_of(group):
                shape = _shape(field, sizes)
                lines.append((length[field.dtype], *shape, *(1,) * (_MAX_AXES - len(shape))))
                length[field.dtype] += math.prod(shape)
        memory: dict[type, np.ndarray] = {dtype: np.zeros(n, dtype) for dtype, n in length.items()}
        self.arrays = (memory[np.float64], memory[np.int64], np.array(lines, dtype=np.int64))
        starts = iter(line[0] for line in lines)

        def view(field: ArrayField) -> np.ndarray:
            shape, start = _shape(field, sizes), next(starts)
            return memory[field.dtype][start : start + math.prod(shape)].reshape(shape)

        self._views: dict[type, Any] = {
            group: group(*(view(field) for field in fields_of(group))) for group in groups
        }

    def group(self, group: type[GroupT]) -> GroupT:
        """Return the views of a group."""
        found: GroupT = self._views[group]
        return found


def _shape(field: ArrayField, sizes: object) -> tuple[int, ...]:
    return tuple(axis if isinstance(axis, int) else getattr(sizes, axis) for axis in field.axes)


@intrinsic  # type: ignore[untyped-decorator]
def _pointer(typing_context: Any, array: Any, index: Any) -> Any:
    """Return the address of an entry of a contiguous array."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        struct = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.gep(struct.data, [arguments[1]])

    return types.CPointer(array.dtype)(array, types.int64), generate


# Views of a pointer instead of slices, which would count references. A line of the table is passed,
# not its number: Numba would compile these anew for each number.
@subkernel
def _one_axis(flat: np.ndarray, line: np.ndarray) -> Any:
    return carray(_pointer(flat, line[0]), (line[1],))


@subkernel
def _two_axes(flat: np.ndarray, line: np.ndarray) -> Any:
    return carray(_pointer(flat, line[0]), (line[1], line[2]))


@subkernel
def _three_axes(flat: np.ndarray, line: np.ndarray) -> Any:
    return carray(_pointer(flat, line[0]), (line[1], line[2], line[3]))


def reader(groups: tuple[type, ...], group: type) -> Callable[..., Any]:
    """Return the compiled function that finds a group in the arrays of a `Memory`."""
    first = sum(len(fields_of(other)) for other in groups[: groups.index(group)])
    views = ("_one_axis", "_two_axes", "_three_axes")
    arguments = ", ".join(
        f"{views[len(field.axes) - 1]}({'reals' if field.dtype is np.float64 else 'integers'}, "
        f"table[{first + k}])"
        for k, field in enumerate(fields_of(group))
    )
    source = f"def read(reals, integers, table):\n    return Group({arguments})\n"
    namespace = {**globals(), "Group": group}
    exec(source, namespace)
    read: Callable[..., Any] = subkernel(namespace["read"])
    return read
