"""Tables of text."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[int] = ()) -> str:
    """Columns as wide as they need to be, two blanks apart.

    Args:
        head: the columns' names.
        rows: of as many texts each.
        right: indices of the columns that are aligned to the right.
    """
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]

    def line(row: Sequence[str]) -> str:
        cells = (
            text.rjust(width) if k in right else text.ljust(width)
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        return "  ".join(cells).rstrip()

    return "\n".join([line(head), "─" * (sum(widths) + 2 * len(widths) - 2), *map(line, rows)])


def paragraph(text: str, indent: int, width: int) -> str:
    """Text in lines of some width, each indented."""
    blank = " " * indent
    return textwrap.fill(text, width, initial_indent=blank, subsequent_indent=blank)
