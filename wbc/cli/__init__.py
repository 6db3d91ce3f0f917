"""Command line: the `wbc` command, one file per subcommand, over the Python API."""

from __future__ import annotations

from collections.abc import Sequence

from wbc.cli.interrupt import exit_on_interrupt


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the `wbc` command; return its exit code, see `wbc.cli.entry.run`.

    Args:
        arguments: the arguments of the command line; those of `sys.argv` by default.
    """
    with exit_on_interrupt():
        from wbc.cli.entry import run
    return run(arguments)


__all__ = ["main"]
