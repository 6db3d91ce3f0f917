"""Standard output and error that never end a run: closed pipes, full devices, ASCII terminals."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
from collections.abc import Iterator
from typing import TextIO, cast

from wbc.errors import WbcError

#: Replacements for terminals without Unicode; other characters become "?".
_ASCII = str.maketrans(
    {
        "µ": "u", "μ": "u", "·": ".", "×": "x", "−": "-", "–": "-", "—": "-", "─": "-", "…": "...",
        "→": "->", "←": "<-", "°": " deg", "±": "+/-", "≤": "<=", "≥": ">=", "²": "^2", "³": "^3",
        "ω": "omega", "ξ": "xi", "τ": "tau", "█": "#", "’": "'", "“": '"', "”": '"',
    }
)  # fmt: skip


class OutputError(WbcError):
    """A result cannot be written to its file."""


class OutputStream(io.TextIOBase):
    """A text stream that records a failure instead of raising it, and discards what follows.

    Characters that the encoding of the stream lacks are replaced by similar ones in ASCII.

    Args:
        stream: the stream to write to; None if the process has none.

    Attributes:
        error: the first failure, or None.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.error: OSError | None = None

    @property
    def closed(self) -> bool:
        """Whether nothing can be written any more."""
        return self._stream is None or self._stream.closed or self.error is not None

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Encoding of the stream."""
        return getattr(self._stream, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        """Return whether the stream is a terminal."""
        return not self.closed and cast(TextIO, self._stream).isatty()

    def fileno(self) -> int:
        """Return the file descriptor of the stream."""
        if self._stream is None:
            raise OSError(errno.EBADF, "the stream is closed")
        return self._stream.fileno()

    def writable(self) -> bool:
        """Return True."""
        return True

    def write(self, text: str) -> int:
        """Write a text; return its length."""
        if not self.closed:
            stream = cast(TextIO, self._stream)
            try:
                try:
                    stream.write(text)
                except UnicodeEncodeError:
                    text = text.translate(_ASCII)
                    stream.write(text.encode(self.encoding, "replace").decode(self.encoding))
            except OSError as error:
                self._fail(error)
        return len(text)

    def flush(self) -> None:
        """Flush the stream."""
        if not self.closed:
            try:
                cast(TextIO, self._stream).flush()
            except OSError as error:
                self._fail(error)

    def _fail(self, error: OSError) -> None:
        self.error = error
        # What is buffered would fail once more when the interpreter ends.
        with contextlib.suppress(OSError, ValueError):
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, self.fileno())
            os.close(null)

    @property
    def failed(self) -> bool:
        """Whether output was lost; a reader that has closed its pipe has what it wants."""
        return self.error is not None and not isinstance(self.error, BrokenPipeError)


@contextlib.contextmanager
def standard_streams() -> Iterator[OutputStream]:
    """Replace `sys.stdout` and `sys.stderr` by streams that do not raise; yields the former."""
    stdout, stderr = OutputStream(sys.stdout), OutputStream(sys.stderr)
    with (
        contextlib.redirect_stdout(cast(TextIO, stdout)),
        contextlib.redirect_stderr(cast(TextIO, stderr)),
    ):
        try:
            yield stdout
        finally:
            stdout.flush()
            stderr.flush()
