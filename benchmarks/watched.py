"""A loop that is watched: each observer with its audience, in processes of their own.

The loop is `wbc.run` in real time, with the controller's own work in every tick and a recorded walk
in place of physics, see `replay`.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from audience import audience
from replay import Replay

import wbc
from wbc.protocols import Controller, Observer, Recorder
from wbc.realtime import RealTime, punctual


@dataclass
class Loop:
    """A loop and who watches it.

    Attributes:
        controller: what it runs; the live page and ROS 2 need a performer.
        plant: what it plays in.
        folder: for files.
        domain: of ROS 2.
        viewer: see `wbc.run`.
        logs: see `wbc.run`.
        before_tick: likewise, in turn.
        paced: one of these waits for the tick's time, so that the loop does not.
        processes: name of an observer -> id of its process.
        figures: what the observers tell afterwards.
    """

    controller: Any
    plant: Replay
    folder: Path
    domain: int = 93
    viewer: Observer | None = None
    logs: list[Recorder] = field(default_factory=list)
    before_tick: list[Callable[[float], None]] = field(default_factory=list)
    paced: bool = False
    processes: dict[str, int] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)

    def run(self, length: float, wanted: RealTime, estimator: Any = None) -> tuple[wbc.Report, str]:
        """Run for so many s; the report, and what the system granted."""

        def before_tick(now: float) -> None:
            for call in self.before_tick:
                call(now)

        told: list[wbc.LoopConditions] = []
        with contextlib.ExitStack() as stack:
            if self.paced:
                told.append(stack.enter_context(punctual(wanted)))
            spent = {name: cpu_seconds(pid) for name, pid in self.processes.items()}
            report = wbc.run(
                self.controller,
                self.plant,
                length,
                estimator=estimator,
                viewer=self.viewer,
                log=tuple(self.logs),
                real_time=False if self.paced else wanted,
                announce=told.append,
                before_tick=before_tick if self.before_tick else None,
            )
        for name, pid in self.processes.items():
            share = (cpu_seconds(pid) - spent[name]) / length
            self.figures[f"{name}: its process, % of a core"] = 100.0 * share
        return report, told[0].describe()


def cpu_seconds(pid: int) -> float:
    """Processor time that a process has had, s; NaN if unknown."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return float("nan")


@contextlib.contextmanager
def viewer(loop: Loop) -> Iterator[None]:
    """The view in the browser."""
    with wbc.view.Meshcat(loop.plant.robot, port=0, announce=False) as meshcat:
        with audience("page", meshcat.url) as rates:
            loop.viewer = meshcat
            loop.processes["viewer"] = meshcat.pid
            yield
        loop.figures["viewer: frames at a page, Hz"] = rates.get("frames", 0.0)


@contextlib.contextmanager
def log(loop: Loop) -> Iterator[None]:
    """The flight recorder."""
    from wbc.log import FlightRecorder
    from wbc.log.reader import Log

    path = loop.folder / f"{time.monotonic_ns()}.mcap"
    with FlightRecorder(path, loop.plant.robot) as recorder:
        loop.logs.append(recorder)
        loop.processes["log"] = recorder.pid
        yield
    own = Log(path).tables["log"]
    minutes = loop.plant.time / 60.0
    if minutes:
        loop.figures["log: MB per minute"] = path.stat().st_size / 1e6 / minutes
    loop.figures["log: ticks dropped"] = float(own["dropped"])
    loop.figures["log: longest write, ms"] = 1e3 * float(own["longest_write_s"])


@contextlib.contextmanager
def ros(loop: Loop, rate: float = 50.0) -> Iterator[None]:
    """The robot's node, and one that listens to joint states, at a rate (Hz), and transforms."""
    from wbc.ros import Network
    from wbc.ros.bridge import Bridge

    with (
        Bridge(
            loop.controller, loop.plant, network=Network(loop.domain), update_rate=rate
        ) as bridge,
        audience("ros", str(loop.domain)) as rates,
    ):
        loop.logs.append(bridge)
        # First: the live page's own call waits for the time of the tick.
        loop.before_tick.insert(0, bridge.helm)
        loop.processes["ROS 2"] = bridge.pid
        yield
    for topic, rate in rates.items():
        loop.figures[f"ROS 2: {topic} at a node, Hz"] = rate


@contextlib.contextmanager
def live(loop: Loop) -> Iterator[None]:
    """The live page."""
    from wbc.live import Live

    with Live(loop.controller, loop.plant, port=0, announce=False) as page:
        with audience("live", page.url) as rates:
            loop.logs.append(page)
            loop.before_tick.append(page.helm)
            loop.paced = True
            loop.processes["live page"] = page.pid
            yield
        loop.figures["live page: frames at a page, Hz"] = rates.get("frames", 0.0)


def fast_ros(loop: Loop) -> contextlib.AbstractContextManager[None]:
    """The same, with as many joint states as there are ticks."""
    return ros(loop, 500.0)


Watching = Callable[[Loop], contextlib.AbstractContextManager[None]]
#: Name of an observer -> how it comes to watch.
OBSERVERS: Mapping[str, Watching] = {
    "viewer": viewer,
    "log": log,
    "ROS 2": ros,
    "ROS 2 at 500 Hz": fast_ros,
    "live page": live,
}
EVERYONE = ("viewer", "log", "ROS 2", "live page")


@contextlib.contextmanager
def watched(loop: Loop, observers: tuple[str, ...]) -> Iterator[Loop]:
    """A loop with these observers."""
    with contextlib.ExitStack() as stack:
        for name in observers:
            stack.enter_context(OBSERVERS[name](loop))
        yield loop


def steady(controller: Controller, velocity: tuple[float, float, float]) -> Callable[[float], None]:
    """For `before_tick`: the velocity of the recording, which an observer's helm sets to zero."""
    begun = False

    def keep(_: float) -> None:
        nonlocal begun
        if not begun:
            begun = True
            controller.velocity = velocity  # type: ignore[attr-defined]

    return keep
