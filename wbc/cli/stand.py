"""`wbc stand`: a robot stands in MuJoCo, with a report."""

from __future__ import annotations

from wbc.cli.argument_types import Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.scripted_run import RunOptions, ScriptedRun


def stand(run: RunOptions, *, duration: Seconds = 5.0) -> ExitCode:
    """Simulate a standing robot in MuJoCo under torque control and print a report.

    Args:
        run: robot, ground and pushes.
        duration: duration, s.
    """
    return ScriptedRun(run, duration).walk([])
