"""The `wbc` command: a thin face over the Python API, one file per subcommand."""

from __future__ import annotations

from collections.abc import Sequence

_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the `wbc` command, see `wbc.cli.entry.main`; Ctrl-C is heard from the first import on."""
    try:
        from wbc.cli.entry import main as run
    except KeyboardInterrupt:
        return _INTERRUPTED
    return run(arguments)


__all__ = ["main"]
