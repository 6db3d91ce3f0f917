"""Where the groups live: two stretches of memory, which a kernel gets as they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wbc.qp.kernels.groups import (
    Contacts,
    Frames,
    Limits,
    Maps,
    Program,
    Rows,
    Tasks,
    Tree,
    Wishes,
)
from wbc.qp.kernels.jit import part

#: Shapes of the arrays of each group, by the sizes of a `Store`; "i" marks whole numbers.
_SHAPES: tuple[tuple[type, tuple[str, ...]], ...] = (
    (Tree, ("i nb", "three", "nb six", "nb six")),
    (Frames, ("i k", "k four four", "k six nv", "k six", "k six")),
    (Tasks, ("i t four", "t four four", "t twelve", "t twelve")),
    (Wishes, ("i j", "j", "two j", "three j")),
    (Contacts, ("i c five", "c three", "c sixteen six", "nf nv", "nf")),
    (Rows, ("i one", "r nv", "r", "r")),
    (Limits, ("i l", "l two", "l three na", "nt")),
    (Maps, ("i s", "i d", "six n1", "nf n1", "na n1", "six n1")),
    (Program, ("rg n1", "n n", "n", "m n", "na+m", "na+m", "n")),
)
_WORDS = {
    "one": 1,
    "two": 2,
    "three": 3,
    "four": 4,
    "five": 5,
    "six": 6,
    "twelve": 12,
    "sixteen": 16,
}


@dataclass(frozen=True, slots=True)
class Sizes:
    """What the shapes of all groups follow from; see the text of the module.

    Attributes:
        na: joints.
        nf: contact force components.
        n: unknowns.
        k: frames, the centroid among them.
        t: tasks on motions.
        j: wishes for single joints.
        c: contacts.
        r: rows of dense tasks and contacts that are not eliminated.
        rg: rows of the cost's residual.
        l: limits on accelerations.
        nt: torques that are limited.
        s: joints that move the eliminated contact.
        d: columns of B that may differ from zero.
        m: rows of C.
    """

    na: int
    nf: int
    n: int
    k: int
    t: int
    j: int
    c: int
    r: int
    rg: int
    l: int  # noqa: E741
    nt: int
    s: int
    d: int
    m: int

    def shape(self, text: str) -> tuple[int, ...]:
        """A shape by its words."""
        derived = {"nb": self.na + 1, "nv": self.na + 6, "n1": self.n + 1, "na+m": self.na + self.m}
        return tuple(
            _WORDS.get(word) or derived.get(word) or int(getattr(self, word, 0))
            for word in text.removeprefix("i ").split()
        )


class Store:
    """All groups of one structure in two stretches of memory, which a kernel gets as they are.

    Unpacking fifty arrays costs a compiled function ten microseconds a call; these three cost a
    tenth of one. `groups_of` makes the groups again on the other side.

    Args:
        sizes: of the structure.

    Attributes:
        arrays: the reals, the integers, and where each array is: (place, three sizes).
    """

    def __init__(self, sizes: Sizes) -> None:
        entries = []
        length = {True: 0, False: 0}
        for _, fields in _SHAPES:
            for text in fields:
                whole, shape = text.startswith("i "), sizes.shape(text)
                entries.append((length[whole], *shape, *(1,) * (3 - len(shape))))
                length[whole] += math.prod(shape)
        reals, integers = np.zeros(length[False]), np.zeros(length[True], dtype=np.int64)
        self.arrays = (reals, integers, np.array(entries, dtype=np.int64))
        made = []
        at = 0
        for group, fields in _SHAPES:
            views = []
            for text in fields:
                shape = sizes.shape(text)
                start = entries[at][0]
                flat = integers if text.startswith("i ") else reals
                views.append(flat[start : start + math.prod(shape)].reshape(shape))
                at += 1
            made.append(group(*views))
        self.tree: Tree
        self.frames: Frames
        self.tasks: Tasks
        self.wishes: Wishes
        self.contacts: Contacts
        self.rows: Rows
        self.limits: Limits
        self.maps: Maps
        self.program: Program
        (self.tree, self.frames, self.tasks, self.wishes, self.contacts) = made[:5]
        (self.rows, self.limits, self.maps, self.program) = made[5:]


# The entry of the table, not its number: Numba would compile these anew for each number.
@part
def _one(flat: np.ndarray, entry: np.ndarray) -> np.ndarray:
    return flat[entry[0] : entry[0] + entry[1]]


@part
def _two(flat: np.ndarray, entry: np.ndarray) -> np.ndarray:
    return flat[entry[0] : entry[0] + entry[1] * entry[2]].reshape(entry[1], entry[2])


@part
def _three(flat: np.ndarray, entry: np.ndarray) -> np.ndarray:
    size = entry[1] * entry[2] * entry[3]
    return flat[entry[0] : entry[0] + size].reshape(entry[1], entry[2], entry[3])


@part
def motion_groups(
    f: np.ndarray, i: np.ndarray, t: np.ndarray
) -> tuple[Tree, Frames, Tasks, Wishes, Contacts]:
    """The first five groups of a store's arrays."""
    return (
        Tree(_one(i, t[0]), _one(f, t[1]), _two(f, t[2]), _two(f, t[3])),
        Frames(_one(i, t[4]), _three(f, t[5]), _three(f, t[6]), _two(f, t[7]), _two(f, t[8])),
        Tasks(_two(i, t[9]), _three(f, t[10]), _two(f, t[11]), _two(f, t[12])),
        Wishes(_one(i, t[13]), _one(f, t[14]), _two(f, t[15]), _two(f, t[16])),
        Contacts(_two(i, t[17]), _two(f, t[18]), _three(f, t[19]), _two(f, t[20]), _one(f, t[21])),
    )


@part
def program_groups(
    f: np.ndarray, i: np.ndarray, t: np.ndarray
) -> tuple[Rows, Limits, Maps, Program]:
    """The other four."""
    return (
        Rows(_one(i, t[22]), _two(f, t[23]), _one(f, t[24]), _one(f, t[25])),
        Limits(_one(i, t[26]), _two(f, t[27]), _three(f, t[28]), _one(f, t[29])),
        Maps(
            _one(i, t[30]),
            _one(i, t[31]),
            _two(f, t[32]),
            _two(f, t[33]),
            _two(f, t[34]),
            _two(f, t[35]),
        ),
        Program(
            _two(f, t[36]),
            _two(f, t[37]),
            _one(f, t[38]),
            _two(f, t[39]),
            _one(f, t[40]),
            _one(f, t[41]),
            _one(f, t[42]),
        ),
    )
