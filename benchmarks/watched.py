"""A loop that is watched: each observer with its audience, in processes of their own.

The loop is `wbc.run` in real time, with the controller's own work in every tick and a recorded walk
in place of physics, see `replay`. Between two ticks an observer can be switched off and on: it is
not called then, and its processes are stopped by a signal.
"""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from audience import audience
from replay import Replay

import wbc
from wbc.runtime.clock import Clock
from wbc.runtime.protocols import Controller, Observer, Recorder
from wbc.runtime.real_time import RealTime, punctual
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.tick import Tick

Helm = Callable[[float], None]
#: Wraps a call of the loop's thread; gets what is called, and whether it waits for the tick first.
Wrap = Callable[[str, Callable[..., None], bool], Callable[..., None]]


@dataclass
class Watcher:
    """One that watches.

    Attributes:
        processes: its own, then its audience.
        recorder: told of every tick.
        helm: called before every tick.
        paces: its helm waits for the tick's time, so that the loop does not.
        on: whether it is called, and its processes run.
    """

    processes: tuple[int, ...]
    recorder: Recorder | None = None
    helm: Helm | None = None
    paces: bool = False
    on: bool = True

    def switch(self, on: bool) -> None:
        """On or off; between two ticks."""
        if on is not self.on:
            self.on = on
            for pid in self.processes:
                os.kill(pid, signal.SIGCONT if on else signal.SIGSTOP)


def _plain(_: str, call: Callable[..., None], __: bool) -> Callable[..., None]:
    return call


@dataclass
class Loop:
    """A loop and who watches it.

    Attributes:
        controller: what it runs; the live page and ROS 2 need a player.
        plant: what it plays in.
        folder: for files.
        domain: of ROS 2; the next one may be used, too.
        velocity: of the recording, which an observer's helm sets to zero; None leaves it.
        before_tick: called before everything else, perhaps to switch watchers.
        wrap: what is done around the watchers' calls.
        watchers: by name.
        figures: what the watchers tell afterwards.
    """

    controller: Any
    plant: Replay
    folder: Path
    domain: int = 93
    velocity: tuple[float, float, float] | None = None
    before_tick: Helm = lambda _: None
    wrap: Wrap = _plain
    watchers: dict[str, Watcher] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)

    def run(self, length: float, wanted: RealTime, estimator: Any = None) -> tuple[wbc.Report, str]:
        """Run for so many s; the report, and what the system granted."""
        spent = {name: cpu_seconds(w.processes[0]) for name, w in self.watchers.items()}
        paced = any(watcher.paces for watcher in self.watchers.values())
        told: list[wbc.LoopConditions] = []
        with contextlib.ExitStack() as stack:
            if paced:
                told.append(stack.enter_context(punctual(wanted)))
            report = wbc.run(
                self.controller,
                self.plant,
                length,
                estimator=estimator,
                log=_Recorders(self),
                real_time=False if paced else wanted,
                announce=told.append,
                before_tick=self._helm(Clock(self.plant.dt, 1) if paced else None),
            )
        for name, watcher in self.watchers.items():
            watcher.switch(True)
            share = (cpu_seconds(watcher.processes[0]) - spent[name]) / length
            self.figures[f"{name}: its process, % of a core"] = 100.0 * share
        return report, told[0].describe()

    def _helm(self, clock: Clock | None) -> Helm:
        """All helms in turn; when the one that paces is off, a clock keeps the time."""
        helms = [
            (w, w.paces, self.wrap(f"{name}: looking for requests", w.helm, w.paces))
            for name, w in self.watchers.items()
            if w.helm is not None
        ]
        helms.sort(key=lambda found: not found[1])  # who waits for the tick comes first

        def before_tick(now: float) -> None:
            self.before_tick(now)
            if clock is not None and not any(w.on and paces for w, paces, _ in helms):
                clock.wait()
            for watcher, _, helm in helms:
                if watcher.on:
                    helm(now)
            if self.velocity is not None and self.plant.ticks == 0:
                self.controller.velocity = self.velocity

        return before_tick


class _Recorders:
    """All recorders of a loop, those that are switched off excepted."""

    def __init__(self, loop: Loop) -> None:
        self._found = [
            (w, w.recorder, loop.wrap(f"{name}: a tick", w.recorder.record, False))
            for name, w in loop.watchers.items()
            if w.recorder is not None
        ]

    def begin(self, controller: Controller, plant: Any) -> None:
        """See `wbc.runtime.protocols.Recorder`."""
        for _, recorder, _ in self._found:
            recorder.begin(controller, plant)

    def record(self, tick: Any, controller: Controller) -> None:
        """See `wbc.runtime.protocols.Recorder`."""
        for watcher, _, record in self._found:
            if watcher.on:
                record(tick, controller)

    def end(self, report: wbc.Report) -> None:
        """See `wbc.runtime.protocols.Recorder`."""
        for _, recorder, _ in self._found:
            recorder.end(report)


class Frames:
    """Shows a viewer 30 snapshots a second, as `wbc.run` does.

    Not by `wbc.run` itself, since that would make them for one that is switched off, too.
    """

    def __init__(self, viewer: Observer, dt: float) -> None:
        self._viewer, self._every, self._count = viewer, max(1, round(1.0 / (30.0 * dt))), 0

    def begin(self, controller: Controller, plant: Any) -> None:
        """See `wbc.runtime.protocols.Recorder`."""

    def record(self, tick: Tick, controller: Controller) -> None:
        """See `wbc.runtime.protocols.Recorder`."""
        if self._count % self._every == 0:
            self._viewer.show(Snapshot.of(tick, controller))
        self._count += 1

    def end(self, report: wbc.Report) -> None:
        """See `wbc.runtime.protocols.Recorder`."""


def cpu_seconds(pid: int) -> float:
    """Processor time that a process has had, s; NaN if unknown."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return float("nan")


@contextlib.contextmanager
def viewer(loop: Loop) -> Iterator[Watcher]:
    """The view in the browser."""
    with wbc.view.Meshcat(loop.plant.robot, port=0, announce=False) as meshcat:
        with audience("page", meshcat.url) as looking:
            yield Watcher((meshcat.pid, looking.pid), Frames(meshcat, loop.plant.dt))
        loop.figures["viewer: frames at a page, Hz"] = looking.rates.get("frames", 0.0)


@contextlib.contextmanager
def log(loop: Loop) -> Iterator[Watcher]:
    """The flight recorder."""
    from wbc.log import FlightRecorder
    from wbc.log.reader import Log

    path = loop.folder / f"{time.monotonic_ns()}.mcap"
    with FlightRecorder(path, loop.plant.robot) as recorder:
        yield Watcher((recorder.pid,), recorder)
    own = Log(path).tables["log"]
    minutes = int(own["ticks"]) * loop.plant.dt / 60.0
    if minutes:
        loop.figures["log: MB per minute"] = path.stat().st_size / 1e6 / minutes
    loop.figures["log: ticks dropped"] = float(own["dropped"])
    loop.figures["log: longest write, ms"] = 1e3 * float(own["longest_write_s"])


def _ros(loop: Loop, name: str, domain: int, rate: float) -> Iterator[Watcher]:
    from wbc.ros import Network
    from wbc.ros.bridge import Bridge

    network = Network(domain)
    with Bridge(loop.controller, loop.plant, network=network, update_rate=rate) as bridge:
        with audience("ros", str(domain)) as listening:
            yield Watcher((bridge.pid, listening.pid), bridge, helm=bridge.helm)
        for topic, reached in listening.rates.items():
            loop.figures[f"{name}: {topic} at a node, Hz"] = reached


@contextlib.contextmanager
def ros(loop: Loop) -> Iterator[Watcher]:
    """The robot's node, and one that listens to joint states and transforms at 50 Hz."""
    yield from _ros(loop, "ROS 2", loop.domain, 50.0)


@contextlib.contextmanager
def fast_ros(loop: Loop) -> Iterator[Watcher]:
    """The same, with as many joint states as there are ticks."""
    yield from _ros(loop, "ROS 2 at 500 Hz", loop.domain + 1, 500.0)


@contextlib.contextmanager
def live(loop: Loop) -> Iterator[Watcher]:
    """The live page, from when it knows what the robot can do."""
    from wbc.live import Live

    with Live(loop.controller, loop.plant, port=0, announce=False) as page:
        with audience("live", page.url) as looking:
            _settled(page.pid)
            yield Watcher((page.pid, looking.pid), page, helm=page.helm, paces=True)
        loop.figures["live page: frames at a page, Hz"] = looking.rates.get("frames", 0.0)


def _settled(pid: int) -> None:
    """Wait until a process has no more to do than to wait."""
    idle = 0
    while idle < 5:
        before = cpu_seconds(pid)
        time.sleep(0.2)
        idle = idle + 1 if cpu_seconds(pid) - before < 0.07 else 0


Watching = Callable[[Loop], contextlib.AbstractContextManager[Watcher]]
#: Name of an observer -> how it comes to watch.
OBSERVERS: Mapping[str, Watching] = {
    "viewer": viewer,
    "log": log,
    "ROS 2": ros,
    "ROS 2 at 500 Hz": fast_ros,
    "live page": live,
}


@contextlib.contextmanager
def watched(loop: Loop, observers: tuple[str, ...]) -> Iterator[Loop]:
    """A loop with these observers."""
    with contextlib.ExitStack() as stack:
        for name in observers:
            loop.watchers[name] = stack.enter_context(OBSERVERS[name](loop))
        yield loop
