"""`wbc log`: contents of a log, and repair of an interrupted one."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path
from typing import Any

from wbc.cli.formatting import table
from wbc.cli.parser import output_file
from wbc.errors import WbcError
from wbc.log.reader import Log
from wbc.log.recovery import repair
from wbc.log.run import LoggedRun


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "log",
        help="print the contents of a log, or repair an interrupted one",
        description="Prints topics, parameters and versions of a log. An interrupted log contains "
        "everything up to its last chunk, but lacks the summary that other programs may need: "
        "--repair writes a complete copy.",
    )
    parser.add_argument("log", metavar="LOG")
    parser.add_argument(
        "--repair",
        type=output_file,
        metavar="FILE",
        help="write a complete copy to FILE, which may be LOG itself",
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Print or repair; return the exit code."""
    path = Path(options.log)
    if options.repair is not None:
        end = repair(_copy(path, options.repair))
        print(f"{options.repair.resolve()}: complete up to {end:.3f} s")
        return 0
    log = Log(path)
    print(_title(log))
    rows = [(topic, kind, str(len(log.stamps(topic)))) for topic, kind in log.topics.items()]
    print(f"\n{table(('topic', 'type', 'messages'), rows, right=(2,))}")
    for name, values in log.tables.items():
        print(f"\n{table((name, ''), list(values.items()))}")
    return 0


def _title(log: Log) -> str:
    size = log.path.stat().st_size / 1e6
    text = f"{log.path}: {size:.1f} MB, "
    text += LoggedRun(log).title if log.topics else "no ticks"
    dropped = log.tables.get("log", {}).get("dropped", "0")
    if dropped != "0":
        text += f"; {dropped} ticks were dropped"
    if not log.complete:
        text += "\nThe log was interrupted; complete it with  wbc log --repair."
    return text


def _copy(path: Path, target: Path) -> Path:
    try:
        if not (target.exists() and path.samefile(target)):
            shutil.copyfile(path, target)
    except OSError as error:
        raise WbcError(f"cannot copy {path} to {target}: {error.strerror}") from error
    return target
