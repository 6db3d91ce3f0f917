"""Makes a controller anew from the recorded inputs of a tick, so that it solves the tick again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from wbc.contacts import Contact, PointContact, SurfaceContact
from wbc.controller import WholeBodyController
from wbc.errors import SolverNotFound, WbcError
from wbc.kinematics import Kinematics
from wbc.limits import (
    AccelerationBound,
    AnyLimit,
    JointPositionLimit,
    JointVelocityLimit,
    Limit,
    LimitRows,
    SelfCollisionLimit,
    TorqueLimit,
)
from wbc.qp import Regularisation, Solver, make_solver
from wbc.robot import Robot
from wbc.tasks import (
    AngularMomentumTask,
    ComTask,
    FrameTask,
    JointCouplingTask,
    OrientationTask,
    PositionTask,
    PostureTask,
    Task,
)


class RecordedTask(Task):
    """A task of a class of somebody's own, by the rows that it wrote."""

    unit = ""

    def __init__(self, entry: dict[str, Any], A: np.ndarray, b: np.ndarray, weight: Any) -> None:
        super().__init__(entry["name"], len(b), weight, 0.0, 0.0, entry["priority"])
        self.labels, self.unit = tuple(entry["labels"]), entry["unit"]  # type: ignore[misc]
        self._A, self._b = A, b

    def write(self, kin: Kinematics, A: np.ndarray, b: np.ndarray) -> None:
        """See `Task.write`."""
        A[:], b[:] = self._A, self._b


class RecordedCone(Contact):
    """A contact of a class of somebody's own, by its cone."""

    def __init__(self, entry: dict[str, Any]) -> None:
        self.motion_size = entry["size"]  # type: ignore[misc]
        self._rows, self._labels = np.array(entry["cone"]), tuple(entry["labels"])
        super().__init__(entry["frame"], name=entry["name"], friction=entry["friction"])

    @property
    def cone_labels(self) -> tuple[str, ...]:
        """See `Contact`."""
        return self._labels

    def make_cone(self, mu: float) -> np.ndarray:
        """See `Contact`: the cone that was recorded."""
        return self._rows


class RecordedContact(RecordedCone):
    """The same for one that wrote the rows of its motion itself."""

    def __init__(self, entry: dict[str, Any], J: np.ndarray, a: np.ndarray) -> None:
        super().__init__(entry)
        self._J, self._a = J, a

    def write(self, kin: Kinematics, J: np.ndarray, a: np.ndarray) -> None:
        """See `Contact.write`."""
        J[:], a[:] = self._J, self._a


class RecordedBound(AccelerationBound):
    """A limit on single joints of a class of somebody's own, by its bounds."""

    name = "limit"

    def __init__(self, entry: dict[str, Any], lower: np.ndarray, upper: np.ndarray) -> None:
        self.name, self.unit = entry["name"], entry["unit"]  # type: ignore[misc]
        self._lower, self._upper = lower, upper

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        return self._lower, self._upper


class RecordedLimit(Limit):
    """A general limit, by the rows that it wrote.

    Args:
        entry: its structure.
        A, lower, upper: its rows.
        forces: coefficients of the force of each contact, in the order of the contacts.
    """

    def __init__(
        self,
        entry: dict[str, Any],
        A: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        *forces: np.ndarray,
    ) -> None:
        super().__init__(
            entry["name"],
            entry["size"],
            unit=entry["unit"],
            labels=entry["labels"],
            priority=entry["priority"],
            weight=entry["weight"],
        )
        self._rows = (A, lower, upper)
        self._forces = forces

    def write(self, kin: Kinematics, rows: LimitRows) -> None:
        """See `Limit.write`."""
        rows.A[:], rows.lower[:], rows.upper[:] = self._rows
        for F, recorded in zip(rows.forces.values(), self._forces, strict=True):
            F[:] = recorded


def recorded_controller(robot: Robot, structure: bytes, values: np.ndarray) -> WholeBodyController:
    """Return a controller with the tasks, contacts and limits of a recorded tick.

    Its `step`, from the state of the tick, returns the command of the tick. Whatever is changed of
    it before, such as a weight or a limit, answers what the tick would have been otherwise.

    Args:
        robot: the robot.
        structure: see `wbc.qp.inputs.ProgramInputs`.
        values: likewise.

    Raises:
        WbcError: there are no inputs, or they do not fit the robot.
    """
    recorded = json.loads(structure or '{"missing": "the command of this tick comes from no QP"}')
    if "missing" in recorded:
        raise WbcError(f"this tick cannot be solved again: {recorded['missing']}")
    reader = _ValueReader(values)
    tasks = [_task(robot, entry, reader) for entry in recorded["tasks"]]
    contacts = [_contact(entry, reader) for entry in recorded["contacts"]]
    limits = [_limit(robot, entry, reader) for entry in recorded["limits"]]
    for contact, entry in zip(contacts, recorded["contacts"], strict=True):
        if entry["placed"]:
            (placement,) = reader.take({"shapes": [[3, 4]]})
            contact.placement = pin.SE3(placement[:, :3].copy(), placement[:, 3].copy())
    solver = _solver(recorded["solver"])
    regularisation = Regularisation(*recorded["regularisation"])
    controller = WholeBodyController(
        robot, recorded["dt"], solver=solver, limits=limits, regularisation=regularisation
    )
    controller.tasks.clear()  # couplings of joints were recorded with the others
    for task in tasks:
        controller.add(task)
    controller.set_contacts(contacts)
    controller.start_from(reader.rest())
    return controller


class _ValueReader:
    """Reads the values of one entry after the other."""

    def __init__(self, values: np.ndarray) -> None:
        self._values, self._at = np.array(values), 0

    def take(self, entry: dict[str, Any]) -> list[np.ndarray]:
        """Return the arrays of the next entry."""
        arrays = []
        for shape in entry["shapes"]:
            size = int(np.prod(shape))
            arrays.append(self._values[self._at : self._at + size].reshape(shape))
            self._at += size
        return arrays

    def rest(self) -> np.ndarray:
        """Return what follows all entries."""
        return self._values[self._at :]


def _solver(name: str) -> Solver:
    """Return the solver of a name, the default one when it is not installed here."""
    try:
        return make_solver(name)
    except SolverNotFound:
        return make_solver()


def _weight(root: np.ndarray, size: int) -> np.ndarray:
    """Return weights from their square roots; an exact task has none."""
    return root * root if root.size else np.ones(size)


def _task(robot: Robot, entry: dict[str, Any], reader: _ValueReader) -> Task:
    arrays = reader.take(entry)
    name, priority = entry["name"], entry["priority"]
    if entry["kind"] == "rows":
        A, b, root = arrays
        return RecordedTask(entry, A, b, _weight(root, b.size))
    if entry["kind"] == "coupling":
        *coefficients, b, root = arrays
        A = np.zeros((1, robot.nv))
        A[0, 6 + np.array(entry["joints"])] = np.ravel(coefficients)
        described = {**entry, "unit": JointCouplingTask.unit, "labels": ()}
        return RecordedTask(described, A, b, _weight(root, 1))
    if entry["kind"] == "joints":
        target, velocity, acceleration, kp, kd, weight = arrays
        posture = PostureTask(
            robot, target, joints=entry["joints"], weight=weight, kp=kp, kd=kd, priority=priority,
            name=name,
        )  # fmt: skip
        posture.velocity, posture.acceleration = velocity, acceleration
        return posture
    pose, velocity, acceleration, kp, kd, root = arrays
    task = _motion_task(entry, pose, velocity, acceleration)
    task.priority, task.labels = priority, tuple(entry["labels"])
    task.unit = entry["unit"]  # type: ignore[misc]
    task.kp, task.kd, task.weight = kp, kd, _weight(root, task.size)
    return task


def _motion_task(
    entry: dict[str, Any], pose: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> Task:
    name, frame, first, size = (entry[key] for key in ("name", "frame", "first", "size"))
    rotation, position = pose[:, :3].copy(), pose[:, 3].copy()
    if not frame and first == 3:
        momentum = AngularMomentumTask(name=name)
        momentum.target, momentum.rate = position, acceleration
        return momentum
    task: ComTask | FrameTask | PositionTask | OrientationTask
    if not frame:
        task = ComTask(position, name=name)
    elif size == 6:
        task = FrameTask(frame, pin.SE3(rotation, position), name=name)
    elif first == 0:
        task = PositionTask(frame, position, name=name)
    else:
        task = OrientationTask(frame, rotation, name=name)
    task.velocity, task.acceleration = velocity, acceleration
    return task


def _contact(entry: dict[str, Any], reader: _ValueReader) -> Contact:
    damping, least, largest, *further = reader.take(entry)
    shared = {"name": entry["name"], "friction": entry["friction"]}
    contact: Contact
    if entry["kind"] == "surface":
        half = entry["half_length"], entry["half_width"]
        contact = SurfaceContact(entry["frame"], *half, **shared)
    elif entry["kind"] == "point":
        contact = PointContact(entry["frame"], **shared)
    elif len(further) > entry["soft"]:
        *further, J, a = further
        contact = RecordedContact(entry, J, a)
    else:
        contact = RecordedCone(entry)
    contact.damping = float(damping[0])
    contact.min_force, contact.max_force = float(least[0]), float(largest[0])
    if entry["soft"]:
        contact.motion_weight = float(further[0][0] ** 2)
    return contact


def _limit(robot: Robot, entry: dict[str, Any], reader: _ValueReader) -> AnyLimit:
    arrays: Sequence[np.ndarray] = reader.take(entry)
    match entry["kind"]:
        case "torque":
            return TorqueLimit(robot, arrays[0])
        case "position":
            horizon, recovery, lower, upper, braking = arrays
            times = {"horizon": float(horizon[0]), "recovery": float(recovery[0])}
            limit = JointPositionLimit(robot, braking=braking, **times)
            limit.lower, limit.upper = lower, upper
            return limit
        case "velocity":
            horizon, maximum, braking = arrays
            return JointVelocityLimit(robot, maximum, horizon=float(horizon[0]), braking=braking)
        case "self-collision":
            return SelfCollisionLimit(robot, **entry["settings"])
        case "bound":
            return RecordedBound(entry, *arrays)
    return RecordedLimit(entry, *arrays)
