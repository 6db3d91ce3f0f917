"""Standard output and error that never end a run: closed pipes, full devices, ASCII terminals."""

from __future__ import annotations

import codecs
import contextlib
import io
import sys
from collections.abc import Iterator
from typing import Any

from wbc.errors import WbcError

#: Replacements for terminals without Unicode; other characters become "?".
_ASCII = str.maketrans(
    {
        "µ": "u", "μ": "u", "·": ".", "×": "x", "−": "-", "–": "-", "—": "-", "─": "-", "…": "...",
        "→": "->", "←": "<-", "°": " deg", "±": "+/-", "≤": "<=", "≥": ">=", "²": "^2", "³": "^3",
        "ω": "omega", "ξ": "xi", "τ": "tau", "█": "#", "’": "'", "“": '"', "”": '"',
    }
)  # fmt: skip


def _similar_characters(error: UnicodeError) -> tuple[str, int]:
    """Replace what an encoding lacks by similar characters; an error handler of `codecs`."""
    assert isinstance(error, UnicodeEncodeError)
    text = error.object[error.start : error.end].translate(_ASCII)
    return text.encode("ascii", "replace").decode(), error.end


codecs.register_error("wbc.similar", _similar_characters)


class OutputError(WbcError):
    """A result cannot be written to its file."""


@contextlib.contextmanager
def writing_results(kind: type[WbcError] = WbcError) -> Iterator[None]:
    """Raise the errors of a kind in the block as `OutputError`."""
    try:
        yield
    except kind as error:
        raise OutputError(str(error)) from error


class OutputStream(io.RawIOBase):
    """A stream of bytes that records a failure instead of raising it, and discards what follows.

    Args:
        stream: the stream to write to; None if the process has none.

    Attributes:
        error: the first failure, or None.
    """

    def __init__(self, stream: Any) -> None:
        buffer = getattr(stream, "buffer", None)
        # Unbuffered: what is buffered would fail once more when the interpreter ends.
        self._raw = getattr(buffer, "raw", buffer)
        self.error: OSError | None = None

    def writable(self) -> bool:
        """Return True."""
        return True

    def isatty(self) -> bool:
        """Return whether the stream is a terminal."""
        return self._raw is not None and self._raw.isatty()

    def fileno(self) -> int:
        """Return the file descriptor of the stream."""
        return super().fileno() if self._raw is None else self._raw.fileno()

    def write(self, data: Any) -> int:
        """Write bytes; return how many."""
        if self._raw is not None and self.error is None:
            try:
                written: int = self._raw.write(data)
                return written
            except OSError as error:
                self.error = error
        return len(data)

    @property
    def lost_output(self) -> bool:
        """Whether output was lost; a reader that has closed its pipe has what it wants."""
        return self.error is not None and not isinstance(self.error, BrokenPipeError)


@contextlib.contextmanager
def standard_streams() -> Iterator[OutputStream]:
    """Replace `sys.stdout` and `sys.stderr` by streams that do not raise; yields the former."""
    stdout, stderr = OutputStream(sys.stdout), OutputStream(sys.stderr)
    with (
        contextlib.redirect_stdout(_text(stdout, sys.stdout)) as out,
        contextlib.redirect_stderr(_text(stderr, sys.stderr)) as err,
    ):
        try:
            yield stdout
        finally:
            out.flush()
            err.flush()


def _text(stream: OutputStream, original: Any) -> io.TextIOWrapper:
    encoding = getattr(original, "encoding", None) or "utf-8"
    buffer = io.BufferedWriter(stream)
    return io.TextIOWrapper(buffer, encoding, errors="wbc.similar", line_buffering=True)
