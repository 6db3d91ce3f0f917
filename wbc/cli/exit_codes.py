"""Exit codes of the `wbc` command."""

from wbc.cli.interrupt import INTERRUPTED

SUCCESS = 0
FAILED = 1  #: the robot fell, the model has errors, the logs differ
BAD_INPUT = 2
OUTPUT_FAILED = 3  #: standard output or a file could not be written
INTERNAL_ERROR = 70  #: an error in the library; EX_SOFTWARE of sysexits.h

__all__ = [
    "BAD_INPUT",
    "FAILED",
    "INTERNAL_ERROR",
    "INTERRUPTED",
    "OUTPUT_FAILED",
    "SUCCESS",
]
