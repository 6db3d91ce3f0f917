"""`wbc log`: contents of a log, and repair of a broken one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from wbc.cli.argument_types import OutputFile
from wbc.cli.formatting import table
from wbc.cli.progress import ProgressBar
from wbc.errors import WbcError
from wbc.log import recovery
from wbc.log.event_rows import EVENT_COLUMNS, event_rows
from wbc.log.reader import Log
from wbc.log.run import LoggedRun

if TYPE_CHECKING:
    from wbc.log.data_section import Gap


def log(log: Path, *, repair: bool = False, out: OutputFile | None = None) -> None:
    """Print topics, events, parameters and versions of a log.

    A log whose process was killed holds everything up to its last chunk, but lacks the end that
    other programs may need; a damaged one lacks the chunks whose checksum is wrong. --repair writes
    a complete copy of what there is, and names the seconds that are missing.

    Args:
        log: path of a log.
        repair: write a complete copy, LOG-repaired.mcap by default; the log stays unchanged.
        out: path of the copy.
    """
    if repair or out is not None:
        print(_repair(log, out))
        return
    with ProgressBar(f"reading {log.name}") as bar:
        contents = Log(log, progress=bar.show)
    print(_title(contents))
    topics = [(name, one.type_name, str(len(one))) for name, one in contents.topics.items()]
    print(f"\n{table(('topic', 'type', 'messages'), topics, right=(2,))}")
    if contents.topics and (events := LoggedRun(contents).events):
        print(f"\n{table(EVENT_COLUMNS, event_rows(events), right=(0,))}")
    for name, values in contents.tables.items():
        print(f"\n{table((name, ''), list(values.items()))}")


def _repair(log: Path, out: Path | None) -> str:
    target = out or log.with_name(f"{log.stem}-repaired{log.suffix}")
    if out is None and target.exists():
        raise WbcError(f"{target} exists; give another path with --out")
    repaired = recovery.repair(log, target)
    text = f"{target.resolve()}: complete up to {repaired.end_time:.3f} s"
    if not repaired.finished:
        text += "; the original was interrupted"
    return text + _missing(repaired.gaps)


def _missing(gaps: Sequence[Gap]) -> str:
    if not gaps:
        return ""
    return "\nmissing, because the file is damaged there: " + "; ".join(map(str, gaps))


def _title(log: Log) -> str:
    size = log.path.stat().st_size / 1e6
    text = f"{log.path}: {size:.1f} MB, {LoggedRun(log).title if log.topics else 'no ticks'}"
    dropped = log.tables.get("log", {}).get("dropped", "0")
    if dropped != "0":
        text += f"; {dropped} ticks were dropped"
    if not log.complete:
        text += "\nThe log was interrupted; complete it with  wbc log --repair."
    return text + _missing(log.gaps)
