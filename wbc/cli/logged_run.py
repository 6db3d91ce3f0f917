"""Arguments of the commands that read a log, and the log that they read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from wbc.cli.argument_types import Argument, number
from wbc.cli.progress import ProgressBar
from wbc.log.run import LoggedRun
from wbc.log.time_span import WHOLE_RUN, TimeSpan


@dataclass(frozen=True)
class SpanOptions:
    """The part of a run to read.

    Attributes:
        start: time of the log from which on it is read, s.
        end: time of the log up to which it is read, s.
    """

    start: Annotated[float, Argument("S", number, "--from")] = -math.inf
    end: Annotated[float, Argument("S", number, "--to")] = math.inf

    def span(self) -> TimeSpan:
        """Return the span.

        Raises:
            LogError: it does not end after its start.
        """
        return TimeSpan(self.start, self.end)


def read_run(log: Path, span: TimeSpan = WHOLE_RUN) -> LoggedRun:
    """Read a run, and show the progress if that takes longer.

    Raises:
        WbcError: it cannot be read.
    """
    with ProgressBar(f"reading {log.name}") as bar:
        return LoggedRun.read(log, span, bar.show)
