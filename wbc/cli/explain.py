"""`wbc explain`: why a tick of a log is what it is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from wbc.cli.argument_types import Argument, RobotName, number
from wbc.cli.logged_run import read_run
from wbc.command import Status
from wbc.log.logged_robot import logged_robot
from wbc.log.logged_tick import LoggedTick


def explain(
    log: Path,
    *,
    at: Annotated[float | None, Argument("T", number)] = None,
    robot: RobotName | None = None,
) -> None:
    """Explain a tick of a log: what tasks asked for and got, and what stood in their way.

    The tick is solved again, alone, from what the log holds of its tasks, contacts and limits.

    Args:
        log: path of a log, see --log of the other subcommands.
        at: time of the tick, s (default: that of the first one).
        robot: the robot, if it cannot be found by its name in the log.
    """
    run = read_run(log)
    loaded = None if robot is None else logged_robot(run.robot_info, robot)
    tick = LoggedTick(run, run.time[0] if at is None else at, loaded)
    print(f"{log}: tick at {tick.time:.3f} s, {tick.status.value}", end="")
    if tick.status is Status.OK:
        print(f"; solved again, torques within {tick.torque_error:.1e} N·m of the log", end="")
    print(f"\n{tick.command.explain()}")
