"""A robot in physics that somebody drives from outside, falls and resets included."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from wbc.errors import PlantError
from wbc.runtime.loop import StopRun, run
from wbc.runtime.protocols import Controller, Observer, Recorder
from wbc.runtime.real_time import RealTime, punctual
from wbc.runtime.report import Report
from wbc.runtime.statistics import Progress


class Driver(Recorder, Protocol):
    """Whom it is driven by, such as the live page or a ROS 2 node."""

    @property
    def helm(self) -> Callable[[float], None]:
        """`before_tick` of `wbc.run`; raises `StopRun` when a reset is wanted."""

    @property
    def paces(self) -> bool:
        """Whether the helm waits for each tick's time itself."""

    @property
    def rescue(self) -> str:
        """How a robot that fell is set on its feet, in words."""

    @property
    def reset_wanted(self) -> bool:
        """Whether a reset has been asked for since the run began."""

    def heed(self, stop: Callable[[], bool]) -> None:
        """Told in the beginning: a helm that waits for long asks it, and raises `StopRun`."""

    def lie(self) -> None:
        """Fallen: show it, look whether a reset is wanted, and wait some milliseconds."""


def drive(
    driver: Driver,
    controller: Controller,
    plant: Any,
    duration: float,
    *,
    viewer: Observer | None = None,
    recording: Observer | None = None,
    log: Sequence[Recorder] = (),
    real_time: bool = True,
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[Progress], None] | None = None,
    told: Callable[[str], None] = lambda _: None,
) -> Report | None:
    """Run until the duration is over. A robot that fell lies until somebody resets it.

    Args:
        driver: who drives.
        controller: whom it drives.
        plant: a simulator.
        duration: s of plant time, those lying down counted by the wall clock.
        viewer: see `wbc.run`.
        recording: see `wbc.run`; shown every run between two resets.
        log: see `wbc.run`; told of every run likewise, after the driver.
        real_time: wait for the wall clock; a driver that paces does so in any case.
        stop: asked now and then; ends it.
        progress: see `wbc.run`.
        told: what happens, in words.

    Returns:
        The report of the last run; None when physics diverged in it.
    """

    def look(now: Progress) -> None:
        if progress is not None:
            progress(now)
        if stop():
            raise StopRun("stopped")

    driver.heed(stop)
    left = duration
    with contextlib.ExitStack() as stack:
        if driver.paces:
            told(stack.enter_context(punctual(RealTime())).describe())
        while True:
            plant.reset()
            report: Report | None = None
            try:
                report = run(
                    controller,
                    plant,
                    left,
                    viewer=viewer,
                    recording=recording,
                    log=(driver, *log),
                    real_time=real_time and not driver.paces,
                    before_tick=driver.helm,
                    progress=look,
                )
                why = report.fell_why if report.fell_at_s is not None else ""
            except PlantError as error:
                why = str(error)
            left -= plant.time
            if not driver.reset_wanted:
                if not why:
                    return report
                told(f"fell: {why}; {driver.rescue}")
                left -= _lie(driver, left, stop)
            if stop() or left <= plant.dt:
                return report
            told("reset")


def _lie(driver: Driver, longest: float, stop: Callable[[], bool]) -> float:
    """Wait for a reset; how long it took, s."""
    start = time.monotonic()
    while not (driver.reset_wanted or stop()):
        driver.lie()
        if time.monotonic() - start >= longest:
            break
    return time.monotonic() - start
