"""`wbc live`: a robot in MuJoCo, driven from the browser."""

from __future__ import annotations

import webbrowser
from typing import Annotated

from wbc.cli import teleoperated_run
from wbc.cli.argument_types import Argument, Port, Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.simulation import Session, Simulation, SimulationOptions
from wbc.live import Live
from wbc.teleop import CommandHandler


def live(
    simulation: SimulationOptions,
    *,
    port: Port | None = None,
    host: Annotated[str, Argument("ADDRESS")] = "127.0.0.1",
    open: bool = False,
    duration: Seconds = teleoperated_run.DURATION,
) -> ExitCode:
    """Simulate a robot in MuJoCo under torque control and serve a page that shows and drives it.

    The page commands velocity, motions, pushes, gait, gains and slow motion, until Ctrl-C. --log,
    --html and --video record the session, falls and resets included.

    Args:
        simulation: robot and ground.
        port: port of the page (default: the first free one from 7000 on).
        host: address to listen on; only this machine reaches the default; who reaches the page
            can drive the robot.
        open: open the page in the browser.
        duration: duration, s.
    """
    simulated = Simulation(simulation)

    def connect(handler: CommandHandler, session: Session) -> Live:
        page = Live(handler, host=host, port=port, boxes=simulated.boxes)
        session.stack.enter_context(page)
        if open:
            webbrowser.open(page.url)
        return page

    return teleoperated_run.run(simulated, duration, connect)
