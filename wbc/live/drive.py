"""A robot in physics that a page drives, falls and resets included."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from wbc.book import Progress
from wbc.errors import PlantError
from wbc.live.live import Live
from wbc.loop import StopRun, run
from wbc.motions import Performer
from wbc.protocols import Recorder
from wbc.realtime import RealTime, punctual
from wbc.report import Report


def drive(
    live: Live,
    performer: Performer,
    plant: Any,
    duration: float,
    *,
    log: tuple[Recorder, ...] = (),
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[Progress], None] | None = None,
    told: Callable[[str], None] = lambda _: None,
) -> Report | None:
    """Run until the duration is over. A robot that fell lies until somebody resets it.

    The page sets the pace: the loop's own clock would not know slow motion.

    Args:
        live: the page.
        performer: whom it drives.
        plant: a simulator.
        duration: s of plant time.
        log: see `wbc.run`; told of every run between two resets.
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

    live.helm.stop = stop
    left = duration
    with punctual(RealTime()) as conditions:
        told(conditions.describe())
        while True:
            plant.reset()
            report: Report | None = None
            try:
                report = run(
                    performer,
                    plant,
                    left,
                    log=(live, *log),
                    before_tick=live.helm,
                    progress=look,
                )
                why = report.fell_why if report.fell_at_s is not None else ""
            except PlantError as error:
                why = str(error)
            left -= plant.time
            if not live.helm.reset_wanted:
                if not why:
                    return report
                told(f"fell: {why}; Reset on the page sets it on its feet")
                live.fell()
                while not (live.helm.reset_wanted or stop()):
                    live.helm.lie()
            if stop() or left <= plant.dt:
                return report
            told("reset")
