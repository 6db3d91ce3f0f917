"""The events of a run as rows of a table."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.runtime.event import COMMAND, RunEvent

#: Titles of the columns.
EVENT_COLUMNS = ("at, s", "event", "by", "outcome", "")


def event_rows(events: Sequence[RunEvent]) -> list[tuple[str, ...]]:
    """Return a row of `EVENT_COLUMNS` for each event.

    Of equal commands in succession, such as those of a joystick, the last stands for all.
    """
    found: list[tuple[RunEvent, int]] = []
    for event in events:
        before = found[-1] if found else None
        if before is not None and event.kind == COMMAND and _alike(event, before[0]):
            found[-1] = event, before[1] + 1
        else:
            found.append((event, 1))
    return [_row(event, count) for event, count in found]


def _alike(a: RunEvent, b: RunEvent) -> bool:
    return (a.kind, a.name, a.source, a.outcome) == (b.kind, b.name, b.source, b.outcome)


def _row(event: RunEvent, count: int) -> tuple[str, ...]:
    what = event.name.replace("_", " ") or event.kind
    if count > 1:
        what += f" ×{count}"
    about = ": ".join(filter(None, (event.value, event.reason)))
    return f"{event.time:.3f}", what, event.source, event.outcome, about
