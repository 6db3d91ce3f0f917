"""Tables and paragraphs of text, as wide as the terminal."""

from __future__ import annotations

import itertools
import shutil
import sys
import textwrap
from collections.abc import Sequence

_MIN_COLUMN = 12  # characters


def _terminal_width() -> int | None:
    """Return the width of the terminal, characters; None if standard output is no terminal."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    right: Sequence[int] = (),
    width: int | None = None,
) -> str:
    """Format a table with columns that are two spaces apart.

    Args:
        head: titles of the columns.
        rows: texts of each row.
        right: indices of the columns to align to the right.
        width: width to which the widest columns are wrapped, characters; by default that of the
            terminal, and unlimited if standard output is none.
    """
    width = width or _terminal_width()
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    gaps = 2 * (len(widths) - 1)
    while width is not None and sum(widths) + gaps > width and max(widths) > _MIN_COLUMN:
        widths[widths.index(max(widths))] -= 1

    def lines(row: Sequence[str]) -> list[str]:
        cells = [textwrap.wrap(text, w) or [""] for text, w in zip(row, widths, strict=True)]
        return [
            "  ".join(
                part.rjust(w) if k in right else part.ljust(w)
                for k, (part, w) in enumerate(zip(parts, widths, strict=True))
            ).rstrip()
            for parts in itertools.zip_longest(*cells, fillvalue="")
        ]

    body = [line for row in rows for line in lines(row)]
    return "\n".join([*lines(head), "─" * (sum(widths) + gaps), *body])


def paragraph(text: str, indent: int = 0) -> str:
    """Wrap a text to the terminal's width, within 40 and 100 characters, and indent its lines."""
    width = max(40, min(_terminal_width() or 80, 100))
    blank = " " * indent
    return textwrap.fill(text, width, initial_indent=blank, subsequent_indent=blank)
