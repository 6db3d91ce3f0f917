"""Entry of the `wbc` command: dispatch to the subcommands, and exit codes."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence

import wbc
from wbc.cli import diff, doctor, live, log, motion, plot, replay, robots, ros2, stand, view, walk
from wbc.cli.exit_codes import (
    BAD_INPUT,
    FAILED,
    INTERNAL_ERROR,
    INTERRUPTED,
    OUTPUT_FAILED,
    SUCCESS,
)
from wbc.cli.output import OutputError, standard_streams
from wbc.cli.parser import Parser
from wbc.errors import WbcError

_EPILOG = """\
exit codes:
  0    the robot survived, the model is sound, the logs are equal
  1    the robot fell, the model has errors, the logs differ
  2    bad usage or bad input
  3    the report or a file could not be written
  70   an error in wbc itself
  130  interrupted by Ctrl-C

examples:
  wbc walk                                     Talos walks; view it in the browser
  wbc walk --robot g1 --velocity 0.2 0 0.1     G1 walks along a curve
  wbc walk --push "3 0 20 0" --no-view         a push of 20 N·s to the left at 3 s
  wbc walk --robot my.urdf --left-foot l_foot --right-foot r_foot
  wbc live --robot g1                          walk, push and tune from the browser
  wbc motion --list                            list the other motions
  wbc motion squat --depth 15 --robot g1       squat by 15 % of the leg length
  wbc walk --log walk.mcap                     record every tick, then
  wbc plot walk.mcap                             plot it
  wbc replay walk.mcap                           replay it in the browser
  wbc diff walk.mcap other.mcap                  find where two runs diverge
  wbc doctor my.urdf                           check a model
"""


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the `wbc` command.

    Args:
        arguments: the arguments of the command line; those of `sys.argv` by default.

    Returns:
        The exit code, see `wbc.cli.exit_codes`.
    """
    # MuJoCo renders nothing here, and without a renderer its import takes half the time.
    os.environ.setdefault("MUJOCO_GL", "disable")
    with standard_streams() as stdout:
        code = _dispatch(arguments)
        stdout.flush()
        if stdout.failed:
            print(f"wbc: cannot write to standard output: {stdout.error}", file=sys.stderr)
            code = OUTPUT_FAILED if code in (SUCCESS, FAILED) else code
    return code


def _dispatch(arguments: Sequence[str] | None) -> int:
    try:
        options = _parser().parse_args(arguments)
        code: int = options.execute(options)
        return code
    except SystemExit as end:  # argparse: --help, --version, bad usage
        return SUCCESS if end.code is None else end.code if isinstance(end.code, int) else BAD_INPUT
    except WbcError as error:
        print(f"wbc: {' '.join(str(error).split())}", file=sys.stderr)
        return OUTPUT_FAILED if isinstance(error, OutputError) else BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:
        traceback.print_exc()
        print("wbc: this is an error in wbc; please report it", file=sys.stderr)
        return INTERNAL_ERROR


def _parser() -> Parser:
    parser = Parser(
        prog="wbc",
        description="Whole-body kinematics and control of humanoids on Pinocchio.",
        epilog=_EPILOG,
    )
    parser.add_argument("--version", action="version", version=f"wbc {wbc.__version__}")
    subcommands = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    for module in (walk, stand, motion, live, view, replay, plot, diff, log, robots, doctor, ros2):
        module.add_to(subcommands)
    return parser
