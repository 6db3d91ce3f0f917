"""A control loop with observers attached, each with a client in a process of its own.

The loop is `wbc.run` in real time: the controller computes every tick, and a recorded walk (see
`replay`) takes the place of physics. Between two ticks an observer can be switched off and on.
While it is off it is not called, and its processes are stopped by SIGSTOP.
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

import wbc
from shared.clients import connected_client
from shared.replay import Replay
from wbc.runtime.clock import Clock
from wbc.runtime.protocols import Controller
from wbc.runtime.real_time import RealTime, real_time_thread
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick

BeforeTick = Callable[[float], None]
#: Wraps a call of the loop's thread; gets what is called, and whether it waits for the tick first.
Wrap = Callable[[str, Callable[..., None], bool], Callable[..., None]]


@dataclass
class AttachedObserver:
    """An observer of the loop.

    Attributes:
        processes: its own, then its client's.
        observer: called after every tick.
        before_tick: called before every tick.
        owns_clock: `before_tick` waits for the time of the tick, so that the loop does not.
        on: whether it is called and its processes run.
    """

    processes: tuple[int, ...]
    observer: Any = None
    before_tick: BeforeTick | None = None
    owns_clock: bool = False
    on: bool = True

    def switch(self, on: bool) -> None:
        """Switch it on or off, between two ticks."""
        if on is not self.on:
            self.on = on
            for pid in self.processes:
                os.kill(pid, signal.SIGCONT if on else signal.SIGSTOP)


def _plain(_: str, call: Callable[..., None], __: bool) -> Callable[..., None]:
    return call


@dataclass
class ObservedLoop:
    """A control loop and its observers.

    Attributes:
        controller: what it runs; the live page and ROS 2 need a player.
        plant: what it plays in.
        folder: for files.
        domain: of ROS 2; the next one may be used, too.
        velocity: of the recording, which an observer's `before_tick` sets to zero; None leaves it.
        before_tick: called before everything else, e.g. to switch observers.
        wrap: applied to each call of an observer.
        observers: by name.
        figures: what the observers measured, by name with unit.
    """

    controller: Any
    plant: Replay
    folder: Path
    domain: int = 93
    velocity: tuple[float, float, float] | None = None
    before_tick: BeforeTick = lambda _: None
    wrap: Wrap = _plain
    observers: dict[str, AttachedObserver] = field(default_factory=dict)
    figures: dict[str, float] = field(default_factory=dict)

    def run(self, length: float, wanted: RealTime, estimator: Any = None) -> tuple[wbc.Report, str]:
        """Run for `length` s; return the report and the loop's conditions."""
        spent = {name: cpu_seconds(w.processes[0]) for name, w in self.observers.items()}
        paced = any(observer.owns_clock for observer in self.observers.values())
        conditions: list[wbc.LoopConditions] = []
        with contextlib.ExitStack() as stack:
            if paced:
                conditions.append(stack.enter_context(real_time_thread(wanted)))
            report = wbc.run(
                self.controller,
                self.plant,
                length,
                estimator=estimator,
                observers=[_SwitchedObservers(self)],
                real_time=False if paced else wanted,
                on_conditions=conditions.append,
                before_tick=self._before_tick(Clock(self.plant.dt, 1) if paced else None),
            )
        for name, observer in self.observers.items():
            observer.switch(True)
            share = (cpu_seconds(observer.processes[0]) - spent[name]) / length
            self.figures[f"{name}: its process, % of a core"] = 100.0 * share
        return report, conditions[0].describe()

    def _before_tick(self, clock: Clock | None) -> BeforeTick:
        """Call all observers in turn; while none owns the clock, this one keeps time."""
        callbacks = [
            (
                w,
                w.owns_clock,
                self.wrap(f"{name}: requests", w.before_tick, w.owns_clock),
            )
            for name, w in self.observers.items()
            if w.before_tick is not None
        ]
        callbacks.sort(key=lambda found: not found[1])  # the owner of the clock comes first

        def before_tick(now: float) -> None:
            self.before_tick(now)
            if clock is not None and not any(w.on and owns_clock for w, owns_clock, _ in callbacks):
                clock.wait()
            for observer, _, callback in callbacks:
                if observer.on:
                    callback(now)
            if self.velocity is not None and self.plant.ticks == 0:
                self.controller.velocity = self.velocity

        return before_tick


class _SwitchedObservers:
    """The observers of a loop; those that are switched off cost nothing.

    They read one stream, as in `wbc.run`; it is written while at least one of them is on.
    """

    def __init__(self, loop: ObservedLoop) -> None:
        found = [w for w in loop.observers.values() if w.observer is not None]
        self._found = [
            (w, w.observer, loop.wrap(f"{name}: a tick", w.observer.observe, False))
            for name, w in loop.observers.items()
            if w.observer is not None
        ]
        quantities = dict.fromkeys(q for w in found for q in w.observer.quantities)
        self._stream = TickStream(loop.plant.robot, tuple(quantities))
        self._write = loop.wrap("writing the tick's record", self._stream.write, False)
        for w in found:
            w.observer.attach(self._stream)

    def begin(self, controller: Controller, plant: Any) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        self._stream.begin_run()
        for _, observer, _ in self._found:
            observer.begin(controller, plant)

    def observe(self, tick: Tick) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        observing = [observe for attached, _, observe in self._found if attached.on]
        if observing:
            self._write(tick)
        for observe in observing:
            observe(tick)

    def end(self, report: wbc.Report) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        for _, observer, _ in self._found:
            observer.end(report)


def cpu_seconds(pid: int) -> float:
    """Return the CPU time of a process, s; NaN if unknown."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return float("nan")


@contextlib.contextmanager
def viewer(loop: ObservedLoop) -> Iterator[AttachedObserver]:
    """Attach the viewer."""
    with wbc.view.Meshcat(loop.plant.robot, port=0, announce=False) as meshcat:
        with connected_client("page", meshcat.url) as client:
            yield AttachedObserver((meshcat.pid, client.pid), meshcat)
        loop.figures["viewer: frames at a page, Hz"] = client.rates.get("frames", 0.0)


@contextlib.contextmanager
def log(loop: ObservedLoop) -> Iterator[AttachedObserver]:
    """Attach the flight recorder."""
    from wbc.log import FlightRecorder
    from wbc.log.reader import Log

    path = loop.folder / f"{time.monotonic_ns()}.mcap"
    with FlightRecorder(path, loop.plant.robot) as recorder:
        yield AttachedObserver((recorder.pid,), recorder)
    own = Log(path).tables["log"]
    minutes = int(own["ticks"]) * loop.plant.dt / 60.0
    if minutes:
        loop.figures["log: MB per minute"] = path.stat().st_size / 1e6 / minutes
    loop.figures["log: ticks dropped"] = float(own["dropped"])
    loop.figures["log: longest write, ms"] = 1e3 * float(own["longest_write_s"])


def _ros(loop: ObservedLoop, name: str, domain: int, rate: float) -> Iterator[AttachedObserver]:
    from wbc.ros import Network
    from wbc.ros.bridge import Bridge
    from wbc.teleop import CommandHandler

    network = Network(domain)
    with (
        CommandHandler(loop.controller, loop.plant, owns_clock=False) as handler,
        Bridge(handler, network=network, update_rate=rate) as bridge,
    ):
        with connected_client("ros", str(domain)) as client:
            processes = (bridge.pid, client.pid)
            yield AttachedObserver(processes, bridge, before_tick=handler.before_tick)
        for topic, reached in client.rates.items():
            loop.figures[f"{name}: {topic} at a node, Hz"] = reached


@contextlib.contextmanager
def ros(loop: ObservedLoop) -> Iterator[AttachedObserver]:
    """Attach the ROS 2 node, with a subscriber to joint states and transforms at 50 Hz."""
    yield from _ros(loop, "ROS 2", loop.domain, 50.0)


@contextlib.contextmanager
def fast_ros(loop: ObservedLoop) -> Iterator[AttachedObserver]:
    """Attach the ROS 2 node, with joint states at every tick."""
    yield from _ros(loop, "ROS 2 at 500 Hz", loop.domain + 1, 500.0)


@contextlib.contextmanager
def live(loop: ObservedLoop) -> Iterator[AttachedObserver]:
    """Attach the live page, once its process has planned its motions."""
    from wbc.live import Live
    from wbc.teleop import CommandHandler

    with (
        CommandHandler(loop.controller, loop.plant) as handler,
        Live(handler, port=0, announce=False) as page,
    ):
        with connected_client("live", page.url) as client:
            _settled(page.pid)
            yield AttachedObserver(
                (page.pid, client.pid), page, before_tick=handler.before_tick, owns_clock=True
            )
        loop.figures["live page: frames at a page, Hz"] = client.rates.get("frames", 0.0)


def _settled(pid: int) -> None:
    """Wait until a process is idle."""
    idle = 0
    while idle < 5:
        before = cpu_seconds(pid)
        time.sleep(0.2)
        idle = idle + 1 if cpu_seconds(pid) - before < 0.07 else 0


Attach = Callable[[ObservedLoop], contextlib.AbstractContextManager[AttachedObserver]]
#: Name of an observer -> context manager that attaches it.
OBSERVERS: Mapping[str, Attach] = {
    "viewer": viewer,
    "log": log,
    "ROS 2": ros,
    "ROS 2 at 500 Hz": fast_ros,
    "live page": live,
}


@contextlib.contextmanager
def observed(loop: ObservedLoop, observers: tuple[str, ...]) -> Iterator[ObservedLoop]:
    """Attach these observers to a loop while the context lasts."""
    with contextlib.ExitStack() as stack:
        for name in observers:
            loop.observers[name] = stack.enter_context(OBSERVERS[name](loop))
        yield loop
