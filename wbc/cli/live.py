"""`wbc live`: a robot in MuJoCo, driven from the browser."""

from __future__ import annotations

import sys
import tempfile
import time
import webbrowser
from pathlib import Path
from typing import Annotated, get_args

from wbc.cli import teleoperated_run
from wbc.cli.argument_types import Argument, Port, Priority, Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.simulation import Session, Simulation, SimulationOptions, TerrainName
from wbc.errors import WbcError
from wbc.live import Live
from wbc.robot import available
from wbc.runtime.real_time import RealTime
from wbc.teleop import CommandHandler, SessionChoices, StartSessionCommand


def live(
    simulation: SimulationOptions,
    *,
    port: Port | None = None,
    host: Annotated[str, Argument("ADDRESS")] = "127.0.0.1",
    open: bool = False,
    priority: Priority | None = None,
    duration: Seconds = teleoperated_run.DURATION,
) -> ExitCode:
    """Simulate a robot in MuJoCo under torque control and serve a page that shows and drives it.

    The page commands velocity, motions, pushes, gait, gains and slow motion, until Ctrl-C; it also
    starts another session, with another robot, terrain or seed. --log, --html and --video record
    each session, falls and resets included; the names of the files of later ones end with a number.

    Args:
        simulation: robot and ground.
        port: port of the page (default: the first free one from 7000 on).
        host: address to listen on; only this machine reaches the default; who reaches the page
            can drive the robot.
        open: open the page in the browser.
        priority: real-time priority of the loop (SCHED_FIFO), 0 for none (default: 40, but none in
            a niced process); what the system grants is printed.
        duration: duration of all sessions together, s.
    """
    with tempfile.TemporaryDirectory(prefix="wbc-") as uploads:
        server = _Sessions(simulation, port, host, Path(uploads), open, RealTime(priority))
        return server.run(duration)


class _Sessions:
    """Sessions one after the other, on one page: each is a process of the page, a log, a recording.

    Args:
        simulation: options of the first session.
        port: see `live`.
        host: see `live`.
        uploads: folder for the files that pages send.
        opens: whether to open the page in the browser.
        real_time: requests of the loop to the system.
    """

    def __init__(
        self,
        simulation: SimulationOptions,
        port: int | None,
        host: str,
        uploads: Path,
        opens: bool,
        real_time: RealTime,
    ) -> None:
        self._real_time = real_time
        self._first, self._host, self._uploads, self._opens = simulation, host, uploads, opens
        self._port = port
        self._token: str | None = None  # of the page, once it is served
        self._handler: CommandHandler | None = None  # of the present session
        self._notice = ""  # what the page of the next session shows

    def run(self, duration: float) -> ExitCode:
        """Run until the duration, s, is over, or no other session is wanted."""
        number, options, left = 1, self._first, duration
        simulated = Simulation(options)
        while True:
            start = time.monotonic()
            code = self._run_session(simulated, options, left)
            left -= time.monotonic() - start
            wanted = self._handler.next_session if self._handler is not None else None
            if wanted is None or left <= 0.0:
                return code
            number += 1
            self._notice = ""
            try:
                following = self._first.for_session(wanted, number)
                simulated = Simulation(following)
                options = following
            except WbcError as error:
                self._notice = f"The session cannot be started: {' '.join(str(error).split())}"
                print(self._notice, file=sys.stderr)
                options = self._first.for_session(_command(options), number)
                simulated = Simulation(options)

    def _run_session(
        self, simulated: Simulation, options: SimulationOptions, duration: float
    ) -> ExitCode:
        present = _command(options)
        choices = SessionChoices(available(), get_args(TerrainName), present)

        def connect(handler: CommandHandler, session: Session) -> Live:
            first = self._token is None
            page = Live(
                handler, host=self._host, port=self._port, boxes=simulated.boxes, announce=first,
                token=self._token, uploads=self._uploads, notice=self._notice,
            )  # fmt: skip
            session.stack.enter_context(page)
            if first and self._opens:
                webbrowser.open(page.url)
            self._handler, self._port, self._token = handler, page.port, page.token
            return page

        return teleoperated_run.run(
            simulated, duration, connect, real_time=self._real_time, sessions=choices
        )


def _command(options: SimulationOptions) -> StartSessionCommand:
    """Return the command that starts a session with these options."""
    return StartSessionCommand(options.robot, options.terrain, options.seed)
