"""`wbc diff`: where two logged runs diverge."""

from __future__ import annotations

import math
from pathlib import Path

from wbc.cli.exit_code import ExitCode
from wbc.cli.formatting import paragraph, table
from wbc.cli.logged_run import SpanOptions, read_run
from wbc.log.diff import Difference, Divergence, compare
from wbc.runtime.event import RunEvent

_WIDTH = 60  # characters of a parameter that are shown
_CONTEXT = 8  # of what is equal before a difference

#: What follows if a stage of the tick is the first that differs. The log holds measurements in
#: single precision, so that smaller differences of them do not show.
_FOLLOWS = {
    "measured": "the measurements differ first: sensors, ground, pushes, initial states or earlier "
    "commands to the motors do",
    "estimated": "the logged measurements are equal until then: the estimators differ, or the "
    "measurements by less than the single precision of the log",
    "intended": "measurements and state are equal until then: the controllers, their commands or "
    "their parameters differ",
    "commanded": "measurements, state and plans are equal until then: the controllers, their "
    "parameters or their solvers differ",
}


def diff(log1: Path, log2: Path, span: SpanOptions, *, tolerance: float = 0.0) -> ExitCode:
    """Compare two logs tick by tick: when they diverge, in which quantity first, and by how much.

    Exit code 0: the logs are equal; 1: they differ.

    Args:
        log1: path of a log.
        log2: path of the other log.
        span: part of the runs.
        tolerance: largest difference to ignore, in SI units, e.g. 1e-6 for the rounding of another
            machine.
    """
    first, second = (read_run(log, span.span()) for log in (log1, log2))
    difference = compare(first, second, tolerance)
    print(f"1  {first.log.path}: {first.title}\n2  {second.log.path}: {second.title}\n")
    if any(difference.commands):
        print("The commands differ, first here:")
        for number, event in enumerate(difference.commands, 1):
            print(f"  {number}  {_command(event)}")
        print()
    if difference.parameters:
        rows = [_row(name, *values) for name, values in difference.parameters.items()]
        print(f"{table(('parameter', 'in 1', 'in 2'), rows)}\n")
    print(_verdict(difference, tolerance))
    if difference.divergences:
        print(f"\n{_divergences(difference.divergences)}")
    same = not difference.divergences and difference.ends[0] == difference.ends[1]
    return ExitCode.SUCCESS if same else ExitCode.FAILED


def _command(event: RunEvent | None) -> str:
    if event is None:
        return "no further command"
    return f"{event.time:.3f} s: {event.name} {event.value} from the {event.source}"


def _verdict(difference: Difference, tolerance: float) -> str:
    first = difference.first
    lines = []
    if first is None:
        within = f" to within {tolerance:g}" if tolerance else ""
        lines.append(f"The runs are equal{within} at all {difference.ticks} common ticks.")
    else:
        gap = f"by {_gap(first)}{first.unit and ' ' + first.unit}"
        lines.append(
            f"The runs diverge at {first.time:.3f} s (common tick {first.tick}), first in a "
            f"{first.stage} quantity:\n"
            f"{first.label}: {_value(first.a)} against {_value(first.b)}, {gap}."
        )
        lines.append(paragraph(f"→ {_FOLLOWS[first.stage]}"))
        known = [
            name
            for name, differs in (
                ("commands", any(difference.commands)),
                ("parameters", bool(difference.parameters)),
            )
            if differs
        ]
        if known:
            lines.append(paragraph(f"→ the {' and '.join(known)} above differ, too"))
    one, other = difference.ends
    if one != other:
        lines.append(
            f"Run {1 if one < other else 2} ends earlier: {one:.3f} s against {other:.3f} s."
        )
    return "\n".join(lines)


def _divergences(divergences: tuple[Divergence, ...]) -> str:
    rows = [
        (
            f"{d.time:.3f}",
            d.stage,
            d.name,
            d.part,
            _gap(d),
            f"{d.largest:.3g}",
            f"{d.largest_time:.3f}",
            d.unit,
        )
        for d in divergences
    ]
    head = ("from, s", "", "quantity", "first in", "by", "at most", "at, s", "unit")
    return table(head, rows, right=(0, 4, 5, 6))


def _gap(divergence: Divergence) -> str:
    gap = abs(divergence.a - divergence.b)
    return f"{gap:.3g}" if math.isfinite(gap) else "unknown"


def _value(x: float) -> str:
    return "unknown" if not math.isfinite(x) else f"{x:.6g}"


def _row(name: str, first: str | None, second: str | None) -> tuple[str, str, str]:
    """Return the row of a parameter; of long values it shows where they begin to differ."""
    values = [value or "—" for value in (first, second)]
    pairs = enumerate(zip(*values, strict=False))
    same = next((i for i, (a, b) in pairs if a != b), min(map(len, values)))
    if max(map(len, values)) > _WIDTH and same > _WIDTH // 2:
        values = [f"…{value[same - _CONTEXT :]}" for value in values]
    return (_short(name), _short(values[0]), _short(values[1]))


def _short(text: str) -> str:
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 3]}…"
