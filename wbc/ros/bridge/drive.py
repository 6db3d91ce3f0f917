"""A robot in physics that a ROS 2 system drives, falls and resets included."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from wbc.book import Progress
from wbc.loop import run
from wbc.protocols import Observer, Recorder
from wbc.report import Report
from wbc.ros.bridge.bridge import Bridge
from wbc.walking import Walker

_LYING = 0.02  # s between two looks at a robot that lies


def drive(
    bridge: Bridge,
    walker: Walker,
    plant: Any,
    duration: float,
    *,
    viewer: Observer | None = None,
    recording: Observer | None = None,
    logs: Sequence[Recorder] = (),
    real_time: bool = True,
    progress: Callable[[Progress], None] | None = None,
    told: Callable[[str], None] = lambda _: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> Report:
    """Run until the duration is over. A robot that fell lies until somebody resets it.

    Args:
        bridge: to the ROS 2 system.
        walker: whom it drives.
        plant: a simulator.
        duration: s of plant time, those lying down counted by the wall clock.
        viewer: see `wbc.run`.
        recording: see `wbc.run`.
        logs: told every tick besides the bridge, see `wbc.run`.
        real_time: see `wbc.run`.
        progress: see `wbc.run`; it may raise `StopRun`.
        told: what happens, in words.
        interrupted: whether to leave a robot that lies.

    Returns:
        The report of the last run.
    """
    left = duration
    while True:
        plant.reset()
        report = run(
            walker,
            plant,
            left,
            viewer=viewer,
            recording=recording,
            log=(bridge, *logs),
            real_time=real_time,
            before_tick=bridge.helm,
            progress=progress,
        )
        left -= report.duration_s
        if bridge.helm.reset_wanted:
            told("reset")
        elif report.fell_at_s is not None:
            told(f"fell: {report.fell_why}; /reset_robot sets it on its feet")
            left -= _lie(bridge, left, interrupted)
            if interrupted():
                return report
            told("reset")
        else:
            return report
        if left <= plant.dt:
            return report


def _lie(bridge: Bridge, longest: float, interrupted: Callable[[], bool]) -> float:
    """Wait for a reset; how long it took, s."""
    start = time.monotonic()
    while not bridge.helm.reset_asked:
        bridge.fallen()
        if interrupted() or time.monotonic() - start >= longest:
            break
        time.sleep(_LYING)
    return time.monotonic() - start
