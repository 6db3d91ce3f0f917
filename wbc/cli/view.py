"""`wbc view`: show a robot in the browser."""

from __future__ import annotations

import math
import time

import wbc
from wbc.cli.argument_types import OutputFile, Seconds
from wbc.cli.model_options import ModelOptions
from wbc.cli.output import writing_results
from wbc.view import Meshcat, Recording, Snapshot


def view(
    robot: str,
    model: ModelOptions,
    *,
    duration: Seconds = math.inf,
    html: OutputFile | None = None,
) -> None:
    """Show a robot in its nominal posture in the browser, until Ctrl-C.

    Args:
        robot: name of a robot, or path of a URDF or robot data file.
        model: properties of the robot.
        duration: stop after S seconds.
        html: write a page that opens offline, and exit.
    """
    loaded = model.load(robot)
    state = loaded.standing()
    com = wbc.Kinematics(loaded, state).p_com.copy()
    snapshot = Snapshot(0.0, state.q, telemetry=wbc.Telemetry(com=com), text=loaded.name)
    if html is not None:
        recording = Recording(loaded)
        recording.show(snapshot)
        with writing_results():
            print(recording.save(html).resolve())
        return
    end = time.monotonic() + duration
    with Meshcat(loaded) as viewer:
        print("Press Ctrl-C to stop.", flush=True)
        try:
            while viewer.alive and time.monotonic() < end:
                viewer.show(snapshot)
                time.sleep(min(0.2, max(end - time.monotonic(), 0.0)))
        except KeyboardInterrupt:
            print()
