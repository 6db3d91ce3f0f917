"""`LoggedTick`: one tick of a log, solved again alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wbc.command import Command, Status
from wbc.errors import WbcError
from wbc.log.errors import LogError
from wbc.log.logged_robot import logged_robot
from wbc.log.run import LoggedRun
from wbc.recorded_tick import recorded_controller
from wbc.runtime.controller_inputs import NAME
from wbc.runtime.quantities import STATUSES
from wbc.state import State

if TYPE_CHECKING:
    from wbc.controller import WholeBodyController
    from wbc.robot import Robot

_TOPIC = f"/{NAME}"


class LoggedTick:
    """The last tick of a log at or before a time: solved again, explained, or changed.

    The log holds what the controller's QP was made of. From it the tick is solved again, alone, to
    the torques of the log (1e-9 N·m with the library's own solvers). After a failed solve the
    torques fade from those of the tick before, which is not solved again.

    Example:
        >>> tick = LoggedTick(LoggedRun.read("walk.mcap"), 3.2)
        >>> print(tick.command.explain())

    Args:
        run: The logged run.
        time: Time, s.
        robot: Robot of the run; by default the one that the log names is loaded.

    Attributes:
        time: Time of the tick, s.
        state: State that the controller saw.
        tau: Torques of the log, N·m, shape (na,).
        status: How the QP ended.
        controller: A controller made anew from the log, with the tasks, contacts and limits of
            the tick. Change any of them and call `controller.step(tick.state)` to see what the
            tick would have been.
        command: The command of this controller, before any change.

    Raises:
        LogError: The log ends before that time or begins after it, does not hold what the tick
            was made of, or its robot cannot be loaded.
    """

    def __init__(self, run: LoggedRun, time: float, robot: Robot | None = None) -> None:
        first, last = float(run.time[0]), float(run.time[-1])
        period = (last - first) / max(len(run.time) - 1, 1)
        if not first - 1e-9 <= time <= last + 1.5 * period:
            raise LogError(
                f"{run.log.path} has no tick at {time:g} s: it goes from {first:g} to {last:g} s"
            )
        tick = int(np.searchsorted(run.time, time + 1e-9, "right")) - 1
        self.time = float(run.time[tick])
        self.state = State(run["q"][tick], run["v"][tick])
        self.tau: np.ndarray = run["tau"][tick]
        self.status: Status = STATUSES[int(run["status"][tick])]
        if _TOPIC not in run.log:
            raise LogError(
                f"{run.log.path} does not hold what its ticks were made of: it was written by an "
                "older wbc, or its commands come from no QP"
            )
        table = run.log[_TOPIC]
        place = int(np.searchsorted(table.stamps, run.stamps[tick]))
        if place == len(table) or table.stamps[place] != run.stamps[tick]:
            raise LogError(
                f"the tick at {self.time:.3f} s of {run.log.path} cannot be solved again: its "
                "command comes from no QP (a fall, a learned policy)"
            )
        message = table.message(place)
        robot = robot or logged_robot(run.robot_info)
        if robot.joint_names != run.robot_info.joints:
            raise LogError(f"the log is of '{run.robot_info.name}', not of '{robot.name}'")
        try:
            self.controller: WholeBodyController = recorded_controller(
                robot, message.structure.encode(), np.array(message.values)
            )
        except (WbcError, KeyError, ValueError, TypeError) as error:
            raise LogError(f"the tick at {self.time:.3f} s of {run.log.path}: {error}") from error
        self.command: Command = self.controller.step(self.state)

    @property
    def torque_error(self) -> float:
        """Largest difference between the torques of the log and of the command, N·m."""
        return float(np.abs(self.command.tau - self.tau).max(initial=0.0))
