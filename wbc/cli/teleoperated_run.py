"""A robot in MuJoCo that is driven from outside, which `wbc live` and `wbc ros2 walk` share."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from wbc import teleop
from wbc.cli.exit_code import ExitCode
from wbc.cli.simulation import Session, Simulation
from wbc.motions import MotionPlayer
from wbc.runtime.real_time import RealTime
from wbc.runtime.report import Report

DURATION = 3600.0  # s, by default


def run(
    simulation: Simulation,
    duration: float,
    connect: Callable[[teleop.CommandHandler, Session], teleop.TeleopClient],
    *,
    owns_clock: bool = True,
    real_time: bool | RealTime = True,
    sessions: teleop.SessionChoices | None = None,
) -> ExitCode:
    """Simulate a robot until the duration is over or Ctrl-C; print the report, write the files.

    Args:
        simulation: the simulated robot.
        duration: s.
        connect: opens the client that drives the robot; it may add observers to the session.
        owns_clock: see `wbc.teleop.CommandHandler`.
        real_time: see `wbc.teleop.run`.
        sessions: see `wbc.teleop.CommandHandler`.

    Raises:
        WbcError: bad input, or a file cannot be written.
    """
    player = MotionPlayer(simulation.robot, walker=simulation.biped_walker)

    def execute(session: Session) -> Report | None:
        handler = session.stack.enter_context(
            teleop.CommandHandler(
                player, simulation.plant, owns_clock=owns_clock, sessions=sessions
            )
        )
        return teleop.run(
            handler,
            duration,
            clients=[connect(handler, session)],
            observers=session.observers,
            real_time=real_time,
            stop=lambda: bool(session.interrupted),
            # Resets, pauses and slow motion make a time left meaningless.
            progress=lambda now: session.line.show_run(replace(now, duration=math.inf)),
            message=session.line.print,
        )

    return simulation.run(execute)
