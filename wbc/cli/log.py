"""`wbc log`: contents of a log, and repair of an interrupted one."""

from __future__ import annotations

import shutil
from pathlib import Path

from wbc.cli.argument_types import OutputFile
from wbc.cli.formatting import table
from wbc.errors import WbcError
from wbc.log import recovery
from wbc.log.reader import Log
from wbc.log.run import LoggedRun


def log(log: Path, *, repair: OutputFile | None = None) -> None:
    """Print topics, parameters and versions of a log.

    An interrupted log contains everything up to its last chunk, but lacks the summary that other
    programs may need: --repair writes a complete copy.

    Args:
        log: path of a log.
        repair: write a complete copy to FILE, which may be LOG itself.
    """
    if repair is not None:
        try:
            if not (repair.exists() and log.samefile(repair)):
                shutil.copyfile(log, repair)
        except OSError as error:
            raise WbcError(f"cannot copy {log} to {repair}: {error.strerror}") from error
        print(f"{repair.resolve()}: complete up to {recovery.repair(repair):.3f} s")
        return
    contents = Log(log)
    print(_title(contents))
    rows = [(name, topic.type_name, str(len(topic))) for name, topic in contents.topics.items()]
    print(f"\n{table(('topic', 'type', 'messages'), rows, right=(2,))}")
    for name, values in contents.tables.items():
        print(f"\n{table((name, ''), list(values.items()))}")


def _title(log: Log) -> str:
    size = log.path.stat().st_size / 1e6
    text = f"{log.path}: {size:.1f} MB, {LoggedRun(log).title if log.topics else 'no ticks'}"
    dropped = log.tables.get("log", {}).get("dropped", "0")
    if dropped != "0":
        text += f"; {dropped} ticks were dropped"
    if not log.complete:
        text += "\nThe log was interrupted; complete it with  wbc log --repair."
    return text
