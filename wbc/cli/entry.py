"""Entry of the `wbc` command."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import wbc
from wbc.cli import diff, doctor, live, log, motion, plot, replay, robots, ros2, stand, view, walk
from wbc.cli.parser import BAD_INPUT, INTERRUPTED, Parser
from wbc.errors import WbcError

_EPILOG = """\
exit code: 0 survived, 1 fell (doctor: errors found, diff: different), 2 bad usage or bad input

examples:
  wbc walk                                     Talos walks, shown in the browser
  wbc walk --robot g1 --velocity 0.2 0 0.1     G1 walks a curve
  wbc walk --push "3 0 20 0" --no-view         20 N·s to the left at 3 s
  wbc walk --robot my.urdf --left-foot l_foot --right-foot r_foot
  wbc live --robot g1                          drive it from the browser: walk, push, tune
  wbc motion --list                            what a robot can do besides
  wbc motion squat --depth 15 --robot g1       down by 15 % of the leg, and up
  wbc walk --log walk.mcap                     keep every tick; then look at it:
  wbc plot walk.mcap                           its pictures;  wbc replay walk.mcap  the run itself
  wbc diff walk.mcap other.mcap                where two runs part
  wbc doctor my.urdf                           what is wrong with a model, and the cure
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the `wbc` command.

    Args:
        arguments: of the command line, without the program's name; `sys.argv` when left out.

    Returns:
        The exit code: 0 survived, 1 fell or errors found, 2 bad usage or bad input, 130 Ctrl-C.
    """
    # Nothing is drawn by MuJoCo: without this, its import starts a process and takes twice as long.
    os.environ.setdefault("MUJOCO_GL", "disable")
    parser = Parser(
        prog="wbc", description="Whole-body control of humanoids on Pinocchio.", epilog=_EPILOG
    )
    parser.add_argument("--version", action="version", version=f"wbc {wbc.__version__}")
    subcommands = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    for module in (walk, stand, motion, live, view, replay, plot, diff, log, robots, doctor, ros2):
        module.add_to(subcommands)
    try:
        options = parser.parse_args(arguments)
        code: int = options.execute(options)
        sys.stdout.flush()
        return code
    except SystemExit as end:  # argparse: --help, --version, bad usage
        return end.code if isinstance(end.code, int) else BAD_INPUT
    except WbcError as error:
        print(f"wbc: {_one_line(error)}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader, say `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
