"""Exit codes of the `wbc` command."""

from enum import IntEnum


class ExitCode(IntEnum):
    """The exit codes of a command and their meanings."""

    SUCCESS = 0
    FAILED = 1  #: the robot fell, the model has errors, the logs differ, results are worse
    BAD_INPUT = 2
    OUTPUT_FAILED = 3  #: standard output or a file could not be written
    INTERNAL_ERROR = 70  #: an error in the library; EX_SOFTWARE of sysexits.h
    INTERRUPTED = 130  #: by Ctrl-C: 128 + SIGINT, as in shells
    TERMINATED = 143  #: by SIGTERM: 128 + SIGTERM, as in shells
