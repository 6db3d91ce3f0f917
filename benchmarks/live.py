"""Measures the latency from a slider to the robot's motion, and the load of the live page.

A page without rendering repeatedly moves a slider of a robot that stands in a real-time run. Three
latencies are measured from the message: to the start of the tick that applies it, to the command of
that tick, and to the arrival of the first frame of that tick or a later one at a page. A run
without the message, which is otherwise identical, shows that the command differs. Further figures
are the CPU time per tick of receiving commands and of publishing ticks, and the slowest tick after
each motion command.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import asyncio
import json
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from shared.clients import socket_address

import wbc
from wbc.live import Live
from wbc.motions import MOTIONS, MotionPlayer
from wbc.runtime.clock import Clock
from wbc.runtime.mode import Mode
from wbc.runtime.real_time import RealTime, real_time_thread
from wbc.runtime.report import Report
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick
from wbc.sim import Mujoco
from wbc.teleop import Acknowledgement, CommandClient, CommandHandler, MotionCommand

Row = dict[str, float | str]
_SETTLE = 0.3  # s of standing before the message
_SAME = 1e-3  # N·m; smaller differences between the torques of two runs are ignored


class Page(threading.Thread):
    """A page without rendering: acknowledges each frame at once and records its arrival."""

    def __init__(self, url: str) -> None:
        super().__init__(daemon=True)
        self._url = url
        self.frames: list[tuple[float, float]] = []  # wall time, plant time
        self.ready = threading.Event()
        self.start()

    def run(self) -> None:
        """Receive frames until the server closes the connection."""
        asyncio.run(self._listen())

    async def _listen(self) -> None:
        from tornado.websocket import websocket_connect

        self._loop = asyncio.get_running_loop()
        self._controls = await websocket_connect(socket_address(self._url, "controls"))
        self._controls_reader = asyncio.ensure_future(self._drain())
        address = socket_address(self._url, "socket")
        scene = await websocket_connect(address, max_message_size=1 << 28)
        while (message := await scene.read_message()) is not None:
            if not isinstance(message, str):
                continue
            news = json.loads(message)
            if "caption" in news:
                self.frames.append((time.perf_counter(), news["caption"]["time"]))
            if "caption" in news or "paths" in news:
                await scene.write_message("frame")
                self.ready.set()

    async def _drain(self) -> None:
        while await self._controls.read_message() is not None:
            pass

    def send(self, control: str, value: float) -> None:
        """Send a control message at once."""
        text = json.dumps({"control": control, "value": value})
        self._loop.call_soon_threadsafe(self._controls.write_message, text)


class TickRecorder:
    """Records when each tick began and when its command was available."""

    def __init__(self, handler: CommandHandler) -> None:
        self._handler = handler
        self._taken = 0
        handler.add_observer(self._count)
        self.began: list[float] = []
        self.ended: list[float] = []
        self.taken: list[int] = []
        self.tau: list[np.ndarray] = []
        self.times: list[float] = []

    def begin(self, controller: object, plant: object) -> None:
        """See `wbc.runtime.protocols.Observer`."""

    def before_tick(self, now: float) -> None:
        """Apply the page's commands."""
        self._handler.before_tick(now)
        self.began.append(time.perf_counter())
        self.taken.append(self._taken)

    def _count(self, *_: object) -> None:
        self._taken += 1

    def observe(self, tick: Tick) -> None:
        """Record the command and its time."""
        self.ended.append(time.perf_counter())
        self.tau.append(tick.command.tau)
        self.times.append(tick.time)

    def end(self, report: Report) -> None:
        """See `wbc.runtime.protocols.Observer`."""


def stand(live: Live, handler: CommandHandler, seconds: float) -> TickRecorder:
    """Reset the plant and run in real time; return the recorded ticks."""
    watch = TickRecorder(handler)
    handler.plant.reset()
    handler.begin()
    both = (watch, live)
    wbc.run(handler.player, handler.plant, seconds, observers=both, before_tick=watch.before_tick)
    return watch


def slider(robot: wbc.Robot, repeats: int) -> tuple[list[Row], dict[str, list[float]]]:
    """Return the latencies from the message on, ms."""
    rng = np.random.default_rng(0)
    spent: dict[str, list[float]] = {
        "to the tick that applies it": [],
        "to the command that differs": [],
        "to its frame at a page": [],
    }
    player = MotionPlayer(robot)
    plant = Mujoco(robot, dt=player.dt)
    seconds = _SETTLE + 0.5
    with (
        CommandHandler(player, plant) as handler,
        Live(handler, port=0, announce=False) as live,
        real_time_thread(RealTime()),
    ):
        page = Page(live.url)
        quiet = stand(live, handler, seconds)
        while not page.ready.is_set():
            handler.on_idle(Mode.PAUSED)
            time.sleep(0.01)
        for k in range(repeats):
            sent: list[float] = []

            def move(value: float, sent: list[float] = sent) -> None:
                sent.append(time.perf_counter())
                page.send("velocity.forward", value)

            # Each value differs slightly, and the phase relative to the ticks is random.
            wait = _SETTLE + float(rng.uniform(0.0, 0.05))
            timer = threading.Timer(wait, move, [0.1 + 1e-4 * k])
            timer.start()
            watch = stand(live, handler, seconds)
            timer.join()
            took = int(np.argmax(np.array(watch.taken) > watch.taken[0]))
            differs = [
                np.abs(a - b).max() > _SAME for a, b in zip(watch.tau, quiet.tau, strict=True)
            ]
            first = differs.index(True)
            assert first == took, f"applied at tick {took}, but the command differs at tick {first}"
            time.sleep(0.2)
            frame = next(
                wall
                for wall, at in page.frames
                if wall > watch.ended[first] and at >= round(watch.times[first], 4) - 1e-4
            )
            for what, wall in zip(
                spent, (watch.began[took], watch.ended[first], frame), strict=True
            ):
                spent[what].append(1e3 * (wall - sent[0]))
    rows: list[Row] = []
    for what, values in spent.items():
        p50, p99, most = np.percentile(values, [50, 99, 100])
        rows.append({"what": f"slider {what}", "unit": "ms", "p50": p50, "p99": p99, "max": most})
    return rows, spent


def torques(robot: wbc.Robot, slower: float, faster: float, at: float) -> list[np.ndarray]:
    """Return the torques, N·m, of the second after a velocity change; not in real time."""
    player = MotionPlayer(robot)
    plant = Mujoco(robot, dt=player.dt)
    found: list[np.ndarray] = []

    class Keeper:
        def begin(self, controller: Any, plant: Any) -> None:
            player.velocity = (slower, 0.0, 0.0)

        def observe(self, tick: Tick) -> None:
            if tick.time > at - 1e-9:
                found.append(tick.command.tau)

        def end(self, report: Report) -> None:
            pass

    def before_tick(now: float) -> None:
        if abs(now - at) < 1e-9:
            player.velocity = (faster, 0.0, 0.0)

    wbc.run(player, plant, at + 1.0, observers=[Keeper()], before_tick=before_tick)
    return found


def walking(robot: wbc.Robot, phases: int) -> Row:
    """Measure the latency from a velocity change while walking to the command, ms plant time."""
    gait = MotionPlayer(robot).walker.gait
    slower, faster = 0.3 * gait.max_velocity.forward, 0.4 * gait.max_velocity.forward
    waits = []
    for k in range(phases):
        at = 0.002 * round((2.0 + k / phases * gait.step_duration) / 0.002)
        pairs = zip(
            torques(robot, slower, slower, at), torques(robot, slower, faster, at), strict=True
        )
        differs = [bool(np.abs(a - b).max() > _SAME) for a, b in pairs]
        waits.append(2.0 * differs.index(True))
    return {
        "what": "walking: velocity change to command",
        "unit": "ms",
        "p50": float(np.median(waits)),
        "max": max(waits),
    }


def cost(robot: wbc.Robot, ticks: int) -> list[Row]:
    """Measure the CPU time per tick that the live page takes from the loop, µs."""
    player = MotionPlayer(robot)
    plant = Mujoco(robot, dt=player.dt)
    looking: list[float] = []
    showing: list[float] = []
    with (
        CommandHandler(player, plant, owns_clock=False) as handler,
        Live(handler, port=0, announce=False) as live,
    ):
        clock = Clock(player.dt, ticks)

        stream = TickStream(robot, live.quantities)
        live.attach(stream)

        class Timed:
            def begin(self, controller: Any, plant: Any) -> None:
                live.begin(controller, plant)

            def observe(self, tick: Tick) -> None:
                start = time.thread_time_ns()
                stream.write(tick)
                live.observe(tick)
                showing.append(1e-3 * (time.thread_time_ns() - start))

            def end(self, report: Report) -> None:
                live.end(report)

        def before_tick(now: float) -> None:
            clock.wait()
            start = time.thread_time_ns()
            handler.before_tick(now)
            looking.append(1e-3 * (time.thread_time_ns() - start))

        player.velocity = (0.1, 0.0, 0.0)
        wbc.run(player, plant, ticks * player.dt, observers=[Timed()], before_tick=before_tick)
    rows: list[Row] = []
    for what, values in (("receiving commands", looking), ("publishing a tick", showing)):
        p50, p99, mean = *np.percentile(values, [50, 99]), np.mean(values)
        rows.append({"what": what, "unit": "µs", "p50": p50, "p99": p99, "mean": mean})
    return rows


def starts(robot: wbc.Robot, seconds: float) -> list[Row]:
    """Measure the slowest tick after each motion command, ms CPU: handler and controller."""
    rows: list[Row] = []
    for kind in MOTIONS:
        player = MotionPlayer(robot)
        plant = Mujoco(robot, dt=player.dt)
        handler = CommandHandler(player, plant, owns_clock=False)
        client = CommandClient(robot, handler.open_channel().config, "benchmark")
        client.start_planning()
        client.send(MotionCommand(kind()))  # as in the process of the page
        refusals: list[Acknowledgement] = []
        while client.planning is not None:
            refusals += client.poll()
            time.sleep(0.01)
        refusals += client.poll()
        if refusals:
            print(f"skipped: {refusals[0].reason}")
            continue
        spent: list[float] = []
        asked = player.dt * round(1.0 / player.dt)
        step = player.step
        clock = Clock(player.dt, 1)

        def timed_step(*arguments: Any, step: Any = step, spent: list[float] = spent) -> Any:
            start = time.thread_time_ns()
            command = step(*arguments)
            spent[-1] += 1e-6 * (time.thread_time_ns() - start)
            return command

        def before_tick(
            now: float,
            handler: CommandHandler = handler,
            spent: list[float] = spent,
            asked: float = asked,
            clock: Clock = clock,
        ) -> None:
            clock.wait()
            start = time.thread_time_ns()
            if now > asked - 1e-9:
                handler.before_tick(now)
            spent.append(1e-6 * (time.thread_time_ns() - start))

        player.step = timed_step  # type: ignore[method-assign]
        wbc.run(player, plant, asked + seconds, before_tick=before_tick)
        first = round(asked / player.dt)
        standing, playing = spent[100:first], spent[first:]
        rows.append(
            {
                "what": f"{kind.name}: slowest tick within {seconds:g} s",
                "unit": "ms",
                "p50": float(np.median(playing)),
                "p99": float(np.percentile(playing, 99)),
                "max": max(playing),
                "first": playing[0],
                "standing": max(standing),
            }
        )
    return rows


def main() -> None:
    """Run the measurements and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--robot", default="talos", help="default: talos")
    parser.add_argument("--repeats", type=int, default=30, help="of the slider (default: 30)")
    parser.add_argument("--ticks", type=int, default=2000, help="of the cost (default: 2000)")
    parser.add_argument(
        "--phases", type=int, default=4, help="of a step, for a robot that walks (default: 4)"
    )
    parser.add_argument(
        "--seconds", type=float, default=5.0, help="of each motion; 0 leaves them out (default: 5)"
    )
    parser.add_argument("--json", type=Path, help="also write the figures there")
    options = parser.parse_args()
    robot = wbc.load(options.robot)
    rows, spent = slider(robot, options.repeats) if options.repeats else ([], {})
    if options.ticks:
        rows += cost(robot, options.ticks)
    if options.seconds:
        rows += starts(robot, options.seconds)
    if options.phases:
        rows.append(walking(robot, options.phases))
    print(f"{robot.name}, {options.repeats} moves of a slider, {options.ticks} ticks")
    for row in rows:
        figures = "   ".join(
            f"{k} {row[k]:8.2f}"
            for k in ("p50", "p99", "mean", "max", "first", "standing")
            if k in row
        )
        print(f"{row['what']!s:36}{row['unit']!s:4}{figures}")
    if options.json is not None:
        results = {"robot": robot.name, "rows": rows, "slider_ms": spent}
        options.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
