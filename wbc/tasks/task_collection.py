"""The tasks of one robot: what controller and inverse kinematics share."""

from __future__ import annotations

from typing import TypeVar

from wbc.errors import TaskError, short_repr
from wbc.robot import RobotModel
from wbc.robot.couplings import Coupling
from wbc.tasks.joint_coupling import JointCouplingTask
from wbc.tasks.task import Task

TaskT = TypeVar("TaskT", bound=Task)


class TaskCollection:
    """Holds tasks with distinct names, bound to a robot.

    Joints of the robot that are coupled (`RobotModel.couplings`) begin as exact tasks.

    Args:
        robot: the robot.
        coupling_kp: gain with which coupled joints that differ come together, 1/s².

    Attributes:
        robot: as given.
        tasks: those added, in order.
    """

    def __init__(self, robot: RobotModel, coupling_kp: float) -> None:
        self.robot = robot
        self.tasks: list[Task] = []
        for coupling in robot.couplings:
            if self._moves(coupling):
                TaskCollection.add(self, _coupling_task(robot, coupling, coupling_kp))

    def _moves(self, coupling: Coupling) -> bool:
        """Return whether one of two coupled joints may move."""
        return True

    def add(self, task: TaskT) -> TaskT:
        """Add a task and return it.

        Raises:
            TaskError: it is no task, or there is one of that name already.
            FrameNotFound: the task's frame is missing; the text lists near names.
        """
        if not isinstance(task, Task):
            raise TaskError(
                f"{short_repr(task)} is no task: add an object such as wbc.ComTask() or one "
                "derived from wbc.Task"
            )
        if any(task.name == other.name for other in self.tasks):
            raise TaskError(
                f"there is a task named '{task.name}' already; give this one another name"
            )
        task.bind(self.robot)
        self.tasks.append(task)
        return task

    def remove(self, task: Task) -> None:
        """Remove a task.

        Raises:
            TaskError: it was never added.
        """
        if task not in self.tasks:
            names = ", ".join(f"'{t.name}'" for t in self.tasks) or "none"
            name = f"'{task.name}'" if isinstance(task, Task) else short_repr(task)
            raise TaskError(f"no task {name} to remove; there are: {names}")
        self.tasks.remove(task)


def _coupling_task(robot: RobotModel, coupling: Coupling, kp: float) -> Task:
    joint, leader = (robot.joint_names[i] for i in (coupling.joint, coupling.leader))
    coefficients = {joint: 1.0, leader: -coupling.ratio}
    return JointCouplingTask(robot, coefficients, coupling.offset, kp=kp, priority=0)
