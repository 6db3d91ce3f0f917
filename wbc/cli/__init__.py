"""The `wbc` command: a thin face over the Python API, one file per subcommand."""

from wbc.cli.entry import main

__all__ = ["main"]
