"""Measures the load of the viewer on the control loop, and the viewer's frame rate.

In a loop at the given rate it times `show` of a complete snapshot, for the live viewer (into shared
memory) and for a recording (into a list). Then it counts the frames per second that a client
receives which acknowledges each at once, and with --browser those that a headless Chromium draws
(in software, much slower than with a GPU).
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import json
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import wbc
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.view import Meshcat, Recording, Snapshot
from wbc.view.browser import SOFTWARE, new_browser

Measurement = dict[str, float | str]


def full_snapshot(robot: wbc.Robot, tick: int, dt: float) -> Snapshot:
    """Return a snapshot of a walk with all its parts."""
    q = robot.q_nominal.copy()
    q[0] += 0.3 * tick * dt
    q[7:] += 0.05 * np.sin(0.01 * tick)
    point = np.array([q[0], 0.0, 0.0])
    telemetry = Telemetry(
        com=point + np.array([0, 0, robot.com_height]),
        dcm=point,
        dcm_reference=point,
        zmp=point,
        phase="double",
    )
    plan = ContactPlan(
        support=point + np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]]),
        footsteps=tuple(Footstep("left", point + 0.2 * k, 0.0) for k in range(4)),
        swing_path=point + np.linspace([0, 0.1, 0], [0.3, 0.1, 0], 20),
    )
    wrenches = {s.name: np.array([0, 0, 4.9 * robot.mass, 1, 1, 0]) for s in robot.soles}
    return Snapshot(tick * dt, q, wrenches, telemetry, plan, text="0.30 m/s, tick 0.4 ms")


def time_action(
    what: str, action: Callable[[Snapshot], object], snapshots: list[Snapshot]
) -> Measurement:
    """Time an action, µs, in a loop at the snapshots' rate."""
    dt = snapshots[1].time - snapshots[0].time
    spent = []
    gc.collect()
    gc.disable()
    due = time.perf_counter()
    for snapshot in snapshots:
        due += dt
        if (left := due - time.perf_counter()) > 3e-4:  # sleeps, then spins, as `wbc.run` does
            time.sleep(left - 3e-4)
        while time.perf_counter() < due:
            pass
        start = time.perf_counter()
        action(snapshot)
        spent.append(time.perf_counter() - start)
    gc.enable()
    p50, p99, most = 1e6 * np.percentile(spent, [50, 99, 100])
    return {"what": what, "p50_us": p50, "p99_us": p99, "max_us": most}


class Client(threading.Thread):
    """A page that draws nothing: it acknowledges every frame at once and counts them."""

    def __init__(self, url: str) -> None:
        super().__init__(daemon=True)
        self.address = url.replace("http", "ws").replace("static/", "socket")
        self.frames = self.nbytes = 0
        self.start()

    def run(self) -> None:
        """Connect and receive until the viewer has ended."""
        asyncio.run(self._listen())

    async def _listen(self) -> None:
        from tornado.websocket import websocket_connect

        socket = await websocket_connect(self.address, max_message_size=1 << 28)
        while (message := await socket.read_message()) is not None:
            if isinstance(message, str) and ("paths" in message or "caption" in message):
                self.frames += "caption" in message
                self.nbytes += len(message)
                await socket.write_message("frame")


def frames(robot: wbc.Robot, rate: float, seconds: float) -> Measurement:
    """Measure the frames per second that reach a client, and their size."""
    with Meshcat(robot, port=0, rate=rate, announce=False) as viewer:
        client = Client(viewer.url)
        tick = 0
        while client.frames < 3:  # until the scene is complete
            viewer.show(full_snapshot(robot, tick := tick + 1, 1.0 / rate))
            time.sleep(1.0 / rate)
        before, nbytes, start = client.frames, client.nbytes, time.perf_counter()
        while time.perf_counter() < start + seconds:
            viewer.show(full_snapshot(robot, tick := tick + 1, 1.0 / rate))
            time.sleep(0.5 / rate)
        count = client.frames - before
        size = (client.nbytes - nbytes) / max(count, 1)
        passed = time.perf_counter() - start
    return {"what": f"frames at {rate:g} Hz", "fps": count / passed, "bytes_per_frame": size}


def browser_frames(robot: wbc.Robot, seconds: float) -> Measurement:
    """Measure the frames per second that a headless Chromium draws."""
    with new_browser(SOFTWARE) as browser, Meshcat(robot, port=0, announce=False) as viewer:
        page = browser.new_page(viewport={"width": 640, "height": 480}, bypass_csp=True)
        viewer.show(full_snapshot(robot, 0, 1 / 30))
        start = time.perf_counter()
        page.goto(viewer.url)
        page.wait_for_function("wbc.ready", timeout=120_000)
        complete = time.perf_counter() - start
        before, start, tick = page.evaluate("wbc.frames"), time.perf_counter(), 0
        while time.perf_counter() < start + seconds:
            viewer.show(full_snapshot(robot, tick := tick + 1, 1 / 30))
            time.sleep(1 / 30)
        count = page.evaluate("wbc.frames") - before
        passed = time.perf_counter() - start
    row: Measurement = {"what": "headless Chromium, 640 x 480", "fps": count / passed}
    return {**row, "complete_after_s": complete}


def recording_file(robot: wbc.Robot, seconds: float) -> Measurement:
    """Time the writing of a recording's file."""
    recording = Recording(robot)
    for tick in range(int(30 * seconds)):
        recording.show(full_snapshot(robot, tick, 1 / 30))
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        path = recording.save(Path(folder) / "run.html")
        duration = time.perf_counter() - start
        size = path.stat().st_size
    return {"what": f"recording of {seconds:g} s", "save_s": duration, "megabytes": size / 1e6}


def show_table(rows: list[Measurement]) -> None:
    """Print the table."""
    for row in rows:
        values = [f"{key} {value:.4g}" for key, value in row.items() if not isinstance(value, str)]
        print(f"  {row['what']:32}" + "  ".join(f"{value:22}" for value in values).rstrip())


def main() -> None:
    """Measure, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="talos")
    parser.add_argument(
        "--rate", type=float, default=500.0, help="rate of the loop, Hz (default: %(default)g)"
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=5.0,
        help="duration of each measurement (default: %(default)g)",
    )
    parser.add_argument("--browser", action="store_true", help="also measure a headless Chromium")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    options = parser.parse_args()

    robot = wbc.load(options.robot)
    dt = 1.0 / options.rate
    snapshots = [full_snapshot(robot, k, dt) for k in range(int(options.seconds * options.rate))]
    rows = []
    with Meshcat(robot, port=0, announce=False) as viewer:
        time.sleep(3.0)  # its meshes are read meanwhile, which is not to be measured
        rows.append(time_action("show, live", viewer.show, snapshots))
    recording = Recording(robot)
    rows.append(time_action("show, recording (every tick)", recording.show, snapshots))
    rows.append(frames(robot, 30.0, options.seconds))
    rows.append(frames(robot, 120.0, options.seconds))
    rows.append(recording_file(robot, 10.0))
    if options.browser:
        rows.append(browser_frames(robot, options.seconds))
    print(f"{robot.name}, loop at {options.rate:g} Hz")
    show_table(rows)
    if options.json:
        text = json.dumps({"robot": robot.name, "rate_hz": options.rate, "rows": rows}, indent=1)
        options.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
