"""`wbc live`: a robot in MuJoCo, driven from the browser."""

from __future__ import annotations

import argparse
import contextlib
from typing import TYPE_CHECKING, Any

from wbc.cli import teleoperated
from wbc.cli.simulation import make_terrain

if TYPE_CHECKING:
    from wbc.live import Live
    from wbc.runtime.protocols import Observer
    from wbc.teleop import CommandHandler


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "live",
        help="drive a robot in MuJoCo from the browser",
        description="Simulates a robot in MuJoCo under torque control and serves a web page that "
        "shows and drives it: velocity, motions, pushes, gait, gains, slow motion. It runs until "
        "Ctrl-C. --log records everything, --html and --video the time since the last reset.",
    )
    parser.add_argument(
        "--port",
        type=_port,
        metavar="N",
        help="port of the page (default: the first free one from 7000 on)",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="address to listen on; anyone who can reach it can drive the robot (default: "
        "127.0.0.1, this machine only)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    teleoperated.add_options(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run; return the exit code."""
    from wbc.live import Live

    def connect(
        handler: CommandHandler, stack: contextlib.ExitStack
    ) -> tuple[Live, list[Observer]]:
        boxes = make_terrain(options).boxes()
        live = stack.enter_context(Live(handler, host=options.host, port=options.port, boxes=boxes))
        if options.open:
            import webbrowser

            webbrowser.open(live.url)
        return live, []

    return teleoperated.run(options, connect)


def _port(text: str) -> int:
    if not (text.isdecimal() and int(text) < 65536):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a port; use 0 to 65535, 0 for any free one"
        )
    return int(text)
