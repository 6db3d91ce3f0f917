"""`wbc log`: what a log holds, and the repair of one that was interrupted."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path
from typing import Any

from wbc.cli.parser import output
from wbc.cli.text import table
from wbc.errors import WbcError
from wbc.log.reader import Log
from wbc.log.recovery import repair
from wbc.log.run import LoggedRun


def add_to(subcommands: Any) -> None:
    """Add the subcommand."""
    parser = subcommands.add_parser(
        "log",
        help="tell what a log holds; repair one that was interrupted",
        description="Tells topics, parameters and versions of a log. A log that was interrupted "
        "holds everything up to its last chunk, but other programs may need its end: "
        "--repair writes a copy that has one.",
    )
    parser.add_argument("log", metavar="LOG")
    parser.add_argument(
        "--repair", type=output, metavar="FILE", help="write a whole copy; may be LOG itself"
    )
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Tell or repair; returns the exit code."""
    path = Path(options.log)
    if options.repair is not None:
        end = repair(_copy(path, options.repair))
        print(f"{options.repair.resolve()}: whole up to {end:.3f} s")
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
    text += LoggedRun(log).title if log.topics else "without a tick"
    dropped = log.tables.get("log", {}).get("dropped", "0")
    if dropped != "0":
        text += f"; {dropped} ticks were dropped"
    if not log.complete:
        text += "\nIt was interrupted; here is what it holds.  wbc log --repair  completes it."
    return text


def _copy(path: Path, target: Path) -> Path:
    try:
        if not (target.exists() and path.samefile(target)):
            shutil.copyfile(path, target)
    except OSError as error:
        raise WbcError(f"cannot copy {path} to {target}: {error.strerror}") from error
    return target
