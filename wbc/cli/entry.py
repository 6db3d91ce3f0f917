"""Entry of the `wbc` command: dispatch to the subcommands, and exit codes."""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from collections.abc import Sequence

import wbc
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import exit_on_interrupt
from wbc.cli.output import OutputError, standard_streams
from wbc.cli.parser import Parser, set_command
from wbc.errors import WbcError

#: Name and summary of each subcommand. Only the module of the one that runs is imported.
_SUBCOMMANDS = {
    "walk": "walk in MuJoCo, shown in the browser, with a report",
    "stand": "stand in MuJoCo, with pushes if you like",
    "motion": "sway, squat, wave, reach and more in MuJoCo",
    "live": "drive a robot in MuJoCo from the browser",
    "robot": "simulate a robot behind the low-level interface of a real one",
    "view": "show a robot in the browser",
    "replay": "replay a log in the browser, or write a video of it",
    "plot": "draw the standard plots of a log",
    "report": "write a log as one page: figures, plots, events, parameters",
    "diff": "find where two logged runs diverge",
    "log": "print the contents of a log, or repair an interrupted one",
    "explain": "say why a tick of a log is what it is",
    "robots": "list the robots that can be loaded by name, or the properties of a robot",
    "doctor": "check a robot description",
    "trials": "push robots in grids of trials, and compare the results",
    "ros2": "run a ROS 2 node or inspect the ROS graph",
}

_EPILOG = """\
exit codes:
  0    the robot survived, the model is sound, the logs are equal
  1    the robot fell, the model has errors, the logs differ, the second results are worse
  2    bad usage or bad input
  3    the report or a file could not be written
  70   an error in wbc itself
  130  interrupted by Ctrl-C; 143 by SIGTERM, which ends a run as well as Ctrl-C does

examples:
  wbc walk                                     Talos walks; view it in the browser
  wbc walk --robot g1 --velocity 0.2 0 0.1     G1 walks along a curve
  wbc walk --push "3 0 20 0" --no-view         a push of 20 N·s to the left at 3 s
  wbc walk --robot my.urdf --left-foot l_foot --right-foot r_foot
  wbc robot unitree-g1                         simulate a G1 in another terminal, then
  wbc walk --hardware unitree                  walk it over its low-level interface
  wbc live --robot g1                          walk, push and tune from the browser
  wbc motion --list                            list the other motions
  wbc motion squat --depth 15 --robot g1       squat by 15 % of the leg length
  wbc walk --log walk.mcap                     record every tick, then
  wbc plot walk.mcap                             plot it
  wbc report walk.mcap                           write figures, plots and events as one page
  wbc replay walk.mcap                           replay it in the browser
  wbc diff walk.mcap other.mcap                  find where two runs diverge
  wbc explain walk.mcap --at 2.5                 see which limits stood in the way of what
  wbc doctor my.urdf                           check a model
  wbc trials benchmarks/grids/quick.toml       push robots, see what they survive
"""


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the `wbc` command.

    Args:
        arguments: the arguments of the command line; those of `sys.argv` by default.

    Returns:
        The exit code, see `wbc.cli.exit_code`.
    """
    # MuJoCo renders nothing here, and without a renderer its import takes half the time.
    os.environ.setdefault("MUJOCO_GL", "disable")
    with standard_streams() as stdout:
        code = _dispatch(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
        if stdout.lost_output:
            print(f"wbc: cannot write to standard output: {stdout.error}", file=sys.stderr)
            if code in (ExitCode.SUCCESS, ExitCode.FAILED):
                code = ExitCode.OUTPUT_FAILED
    return code


def _dispatch(arguments: Sequence[str]) -> int:
    try:
        parser, arguments = _parser(arguments)
        options = parser.parse_args(arguments)
        return int(options.execute(options) or ExitCode.SUCCESS)
    except SystemExit as end:  # argparse: --help, --version, bad usage
        return int(end.code or ExitCode.SUCCESS)
    except WbcError as error:
        print(f"wbc: {' '.join(str(error).split())}", file=sys.stderr)
        failed = isinstance(error, OutputError)
        return ExitCode.OUTPUT_FAILED if failed else ExitCode.BAD_INPUT
    except KeyboardInterrupt:
        return ExitCode.INTERRUPTED
    except Exception:
        traceback.print_exc()
        print("wbc: this is an error in wbc; please report it", file=sys.stderr)
        return ExitCode.INTERNAL_ERROR


def _parser(arguments: Sequence[str]) -> tuple[Parser, Sequence[str]]:
    """Return the parser of the subcommand that the arguments name, and complete arguments.

    The parser has the options of that subcommand only. A subcommand with a `DEFAULT_VERB` gets it
    when the first argument is no other verb.
    """
    parser = Parser(
        prog="wbc",
        description="Whole-body kinematics and control of humanoids on Pinocchio.",
        epilog=_EPILOG,
    )
    parser.add_argument("--version", action="version", version=f"wbc {wbc.__version__}")
    subcommands = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    place = next((i for i, text in enumerate(arguments) if not text.startswith("-")), None)
    for name, summary in _SUBCOMMANDS.items():
        subcommand = subcommands.add_parser(name, help=summary)
        if place is None or name != arguments[place]:
            continue
        with exit_on_interrupt():  # the import takes up to a second
            module = importlib.import_module(f"wbc.cli.{name}")
        if not hasattr(module, "add_verbs"):
            set_command(subcommand, getattr(module, name))
            continue
        module.add_verbs(subcommand)
        following = arguments[place + 1 :]
        default = getattr(module, "DEFAULT_VERB", None)
        if default and following and following[0] not in {*module.VERBS, "-h", "--help"}:
            arguments = [*arguments[: place + 1], default, *following]
    return parser, arguments
