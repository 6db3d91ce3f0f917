"""What the QP of a tick is made of beside the state, as numbers: to log and solve it again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from wbc.contacts import Contact, PointContact, SurfaceContact
from wbc.limits import (
    AccelerationBound,
    AnyLimit,
    JointPositionLimit,
    JointVelocityLimit,
    Limit,
    SelfCollisionLimit,
    TorqueLimit,
)
from wbc.robot import Robot
from wbc.tasks import JointCouplingTask, JointTask, MotionTask, Task
from wbc.tasks.motion import CENTROID

#: What tasks, contacts and limits have written into an assembly's memory, as views of it.
Written = Mapping[object, Sequence[np.ndarray]]
_DENSE = 3  # arrays of a task that writes its rows itself: A, b and the weights
_HEAD = 2  # words: number of bytes of the structure, number of values


class ProgramInputs:
    """Packs the inputs of one structure of the QP, tick by tick.

    The structure is JSON: kinds, names, frames and sizes of tasks, contacts and limits, each of
    which has some of the values; `wbc.recorded_tick` makes them anew from both. Tasks, contacts
    and limits of other classes than the library's own are recorded by the rows that they wrote.
    A change of the settings of a self-collision limit, or of which joints a `JointCouplingTask`
    couples, is recorded with the next structure only.

    Args:
        robot: the robot.
        tasks: the tasks, in the order of the controller.
        contacts: the contacts.
        limits: the limits.
        written: what each of them writes into the memory of the assembly.
        memory: the reals of the assembly.
        settings: further entries of the structure.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: Sequence[Task],
        contacts: Sequence[Contact],
        limits: Sequence[AnyLimit],
        written: Written,
        memory: np.ndarray,
        settings: Mapping[str, Any],
    ) -> None:
        self._robot = robot
        self._owners = (tuple(tasks), tuple(contacts), tuple(limits))
        self._written: dict[object, Sequence[np.ndarray]] = dict(written)
        for task in tasks:
            if type(task) is JointCouplingTask:  # most of its row is zero
                A, *further = self._written[task]
                columns = [A[:, 6 + joint : 7 + joint] for joint in _coupled(task)]
                self._written[task] = (*columns, *further)
        for limit in limits:
            if type(limit) is SelfCollisionLimit:  # its rows are many and follow from the state
                self._written[limit] = ()
        self._memory, self._settings = memory, settings
        places = [
            _places(view, memory)
            for owner in (*tasks, *contacts, *limits)
            for view in self._written[owner]
        ]
        self._places = np.concatenate(places) if places else np.empty(0, int)
        self._placed = [contact for contact in contacts if contact.placement is not None]
        self._cones: list[np.ndarray] = []
        self._words = np.empty(0)

    def pack(self, words: int, working_set: np.ndarray) -> np.ndarray:
        """Return the inputs of the last tick, (words,); they are overwritten by the next call.

        Args:
            words: size of the result. When the inputs need more, it says that they are missing.
            working_set: (k,) what the solver ended with, always of one size.
        """
        cones = [contact.cone for contact in self._owners[1]]
        same = len(cones) == len(self._cones) and all(map(_is, cones, self._cones))
        count = self._places.size
        further = np.concatenate((*map(_placement, self._placed), working_set))
        if not same or self._words.size != words:
            self._cones = cones
            values = np.zeros(count + further.size)
            self._words = pack_inputs(self._structure(working_set.size), values, words)
            self._fits = int(self._words[1]) == values.size
            self._start = _HEAD + -(-int(self._words[0]) // 8)
        if self._fits:
            end = self._start + count
            # "clip" writes without a buffer: in a quarter of the time.
            self._memory.take(self._places, out=self._words[self._start : end], mode="clip")
            self._words[end : end + further.size] = further
        return self._words

    def _structure(self, working_set: int) -> dict[str, Any]:
        tasks, contacts, limits = self._owners
        return {
            **self._settings,
            "tasks": [
                _sized(_task(self._robot, t, self._written[t]), self._written[t]) for t in tasks
            ],
            "contacts": [_sized(_contact(c), self._written[c]) for c in contacts],
            "limits": [_sized(_limit(x), self._written[x]) for x in limits],
            "working_set": working_set,
        }


def pack_inputs(structure: Mapping[str, Any], values: np.ndarray, words: int) -> np.ndarray:
    """Return structure and values as (words,) numbers; those that do not fit are left out."""
    text = json.dumps(structure, ensure_ascii=False, separators=(",", ":")).encode()
    if _HEAD + -(-len(text) // 8) + values.size > words:
        missing = f"the inputs of the QP need more than the {words} numbers that are reserved"
        return pack_inputs({"missing": missing}, np.empty(0), words)
    packed = np.zeros(words)
    size = -(-len(text) // 8)
    packed[:_HEAD] = len(text), values.size
    packed[_HEAD : _HEAD + size].view(np.uint8)[: len(text)] = np.frombuffer(text, np.uint8)
    packed[_HEAD + size : _HEAD + size + values.size] = values
    return packed


def packed_text(words: np.ndarray) -> bytes:
    """Return the structure in packed inputs, as JSON; empty when there are none."""
    size = int(words[0]) if np.isfinite(words[0]) else 0
    return np.ascontiguousarray(words[_HEAD : _HEAD + -(-size // 8)]).tobytes()[:size]


def packed_values(words: np.ndarray) -> np.ndarray:
    """Return the values in packed inputs; none when there are none."""
    if not np.isfinite(words[0]):
        return np.empty(0)
    start = _HEAD + -(-int(words[0]) // 8)
    values: np.ndarray = words[start : start + int(words[1])]
    return values


def _placement(contact: Contact) -> np.ndarray:
    """Return the placement of a contact in its frame, (12,): exact, as that in its joint is not.

    Soft contacts alone leave the QP so ill-conditioned that rounding would show in the torques.
    """
    assert contact.placement is not None
    numbers: np.ndarray = contact.placement.homogeneous[:3].ravel()
    return numbers


def _is(one: object, other: object) -> bool:
    return one is other


def _places(view: np.ndarray, memory: np.ndarray) -> np.ndarray:
    """Return where the entries of a view lie in the memory."""
    places = np.array((view.ctypes.data - memory.ctypes.data) // memory.itemsize)
    for count, stride in zip(view.shape, view.strides, strict=True):
        places = np.add.outer(places, np.arange(count) * (stride // memory.itemsize))
    return places.ravel()


def _sized(entry: dict[str, Any], written: Sequence[np.ndarray]) -> dict[str, Any]:
    return {**entry, "shapes": [list(view.shape) for view in written]}


def _task(robot: Robot, task: Task, written: Sequence[np.ndarray]) -> dict[str, Any]:
    common = {"name": task.name, "priority": task.priority}
    described = {**common, "unit": task.unit, "labels": list(task.labels), "size": task.size}
    if isinstance(task, MotionTask) and type(task).write is MotionTask.write:
        of_centroid = task.frame_id == CENTROID
        frame = "" if of_centroid else robot.model.frames[task.frame_id].name
        return {**described, "kind": "motion", "frame": frame, "first": task.components.start}
    if type(task) is JointCouplingTask:
        return {**common, "kind": "coupling", "joints": _coupled(task)}
    if isinstance(task, JointTask) and len(written) > _DENSE:
        joints = [robot.joint_names[i] for i in task.index]
        return {**common, "kind": "joints", "joints": joints}
    return {**described, "kind": "rows"}


def _coupled(task: JointCouplingTask) -> list[int]:
    """Return the joints of a coupling, as indices into (na,) vectors."""
    return [int(joint) for joint in np.flatnonzero(task.coefficients)]


def _contact(contact: Contact) -> dict[str, Any]:
    common = {
        "name": contact.name,
        "frame": contact.frame,
        "soft": contact.motion_weight is not None,
        "placed": contact.placement is not None,
        "friction": contact.friction,
    }
    if type(contact) is SurfaceContact:
        size = {"half_length": contact.half_length, "half_width": contact.half_width}
        return {**common, "kind": "surface", **size}
    if type(contact) is PointContact:
        return {**common, "kind": "point"}
    return {
        **common,
        "kind": "rows",
        "cone": contact.cone.tolist(),
        "labels": list(contact.cone_labels),
        "size": contact.motion_size,
    }


def _limit(limit: AnyLimit) -> dict[str, Any]:
    if isinstance(limit, TorqueLimit):
        return {"kind": "torque"}
    if isinstance(limit, AccelerationBound):
        for kind, library in (("position", JointPositionLimit), ("velocity", JointVelocityLimit)):
            if isinstance(limit, library) and type(limit).bounds is library.bounds:
                return {"kind": kind}
        return {"kind": "bound", "name": limit.name, "unit": limit.unit}
    assert isinstance(limit, Limit)
    if type(limit) is SelfCollisionLimit:
        names = ("name", "size", "margin", "detection", "gain", "recovery")
        return {
            "kind": "self-collision",
            "settings": {name: getattr(limit, name) for name in names},
        }
    return {
        "kind": "rows",
        "name": limit.name,
        "size": limit.size,
        "unit": limit.unit,
        "labels": list(limit.labels),
        "priority": limit.priority,
        "weight": limit.weight,
    }
