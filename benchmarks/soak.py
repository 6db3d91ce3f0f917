"""Injects faults at random into sessions of `wbc live`, and tells what was lost.

The first session lasts half of the time, and only faults that it must survive are injected: pages
are opened, closed, killed and no longer read, flood it with commands and rubbish, drive and vanish,
make the robot fall, save stretches; its processes are stopped for seconds. Shorter sessions follow,
each with such faults and then an end by force: SIGTERM, SIGINT, SIGKILL, a killed log writer, a
full disk (a limit of the file's size), a killed page server.

Nothing is lost when every command was answered, every accepted command and every tick is in the
log, and the files of a session are whole: of a session that ends in order, all of it; where the
loop or the log writer is killed, all but the last second. Beside each fault the ticks that ended
late by more than a period are counted, and compared with the time without faults.

    python benchmarks/soak.py --minutes 60 --seed 0

It needs Linux. The exit code is 1 if something was lost.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import asyncio
import json
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from shared.processes import child_processes, descriptors, is_running, private_memory
from shared.soak_checks import Verdict, check_session
from shared.soak_page import Page
from shared.soak_session import TICK

SESSION = Path(__file__).parent / "shared" / "soak_session.py"
SERVER, WRITER = "wbc.live.server", "wbc.log.writer"
ENDINGS = ("SIGTERM", "SIGINT", "SIGKILL", "log writer killed", "disk full", "page server killed")
SHORT = 25.0  # s of a session after the first one
SETTLING = 3.0  # s between a fault and the next one
AFTER = 1.5  # s after a fault that count to it
MEMORY_PERIOD = 2.0  # s
LIMIT = 300_000  # bytes that a full disk still takes


@dataclass
class Fault:
    """A fault that was injected.

    Attributes:
        kind: What it was.
        start: When it began, s by the monotonic clock.
        end: When its effect is over at the latest, s.
    """

    kind: str
    start: float
    end: float


@dataclass
class Memory:
    """Memory of a process over time.

    Attributes:
        time: s by the monotonic clock.
        megabytes: Memory that only this process has.
        descriptors: Open file descriptors.
    """

    time: list[float] = field(default_factory=list)
    megabytes: list[float] = field(default_factory=list)
    descriptors: list[int] = field(default_factory=list)


class Session:
    """A session of `wbc live` and the pages that it has.

    Args:
        folder: Folder for its files.
        robot: Name of the robot.
        seconds: Its duration at most.
        rng: Random numbers.
        html: Whether it also writes a recording, whose memory grows with the session.
    """

    def __init__(
        self, folder: Path, robot: str, seconds: float, rng: random.Random, html: bool
    ) -> None:
        self.folder, self.rng, self.html = folder, rng, html
        folder.mkdir()
        shared = Path("/dev/shm")
        self._shared = tempfile.mkdtemp(prefix="soak-", dir=shared if shared.is_dir() else None)
        self.ticks_file = Path(self._shared, "ticks")
        (folder / "tmp").mkdir()
        command = [
            sys.executable, str(SESSION), str(self.ticks_file), str(2.0 * seconds + 60.0),
            "--robot", robot, "--port", "0", "--priority", "40",
            "--log", str(folder / "log.mcap"), "--json", str(folder / "report.json"),
        ]  # fmt: skip
        if html:
            command += ["--html", str(folder / "recording.html")]
        environment = {**os.environ, "TMPDIR": str(folder / "tmp"), "PYTHONUNBUFFERED": "1"}
        self.output = (folder / "output.txt").open("w+")
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=self.output, env=environment, text=True
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line.startswith("Live: "):
            raise SystemExit(f"no session: {line}{(folder / 'output.txt').read_text()}")
        self.url = line.removeprefix("Live: ").strip()
        self.children = child_processes(self.process.pid)
        self.pages: list[Page] = []
        self.closed: list[Page] = []
        self.faults: list[Fault] = []
        self.memory = {name: Memory() for name in ("loop", *self.children)}
        self.stops: list[float] = []  # s from the end of a page that drives to a velocity of zero

    async def sample_memory(self) -> None:
        """Note the memory of the processes until cancelled."""
        while True:
            for name, pid in {"loop": self.process.pid, **self.children}.items():
                one = self.memory[name]
                one.time.append(time.monotonic())
                one.megabytes.append(private_memory(pid))
                one.descriptors.append(descriptors(pid))
            await asyncio.sleep(MEMORY_PERIOD)

    async def page(self) -> Page:
        """Return an open page, at random."""
        if not self.pages:
            await self.open_page()
        return self.rng.choice(self.pages)

    async def open_page(self) -> None:
        """Open a page."""
        self.pages.append(await Page.open(self.url))

    async def watcher(self) -> Page:
        """Return a page that shows the status."""
        page = await self.page()
        while not page.status and not page.lost:
            await asyncio.sleep(0.02)
        return page

    async def running(self) -> None:
        """Wait until the robot runs, and reset it if it has fallen."""
        page = await self.watcher()
        if page.status.get("mode") == "fallen":
            page.send("reset")
        end = time.monotonic() + 15.0
        while page.status.get("mode") != "running" and time.monotonic() < end and not page.lost:
            await asyncio.sleep(0.05)

    async def end_page(self, kill: bool) -> None:
        """Close or kill a page, when its commands were answered."""
        page = await self.page()
        await page.settle(5.0)
        self.pages.remove(page)
        self.closed.append(page)
        if kill:
            page.kill()
        else:
            await page.close()

    def ticks(self) -> np.ndarray:
        """Return the ticks so far."""
        ticks = np.array(np.memmap(self.ticks_file, TICK, "r"))
        return ticks[ticks["ended"] > 0.0]

    def remove(self) -> None:
        """Remove what the session has in memory."""
        shutil.rmtree(self._shared, ignore_errors=True)


# ---- Faults that a session survives ----


async def open_and_close(session: Session) -> None:
    """Open a page, and close another."""
    await session.open_page()
    if len(session.pages) > 2:
        await session.end_page(kill=False)


async def kill_page(session: Session) -> None:
    """Kill a page."""
    await session.end_page(kill=True)


async def stall_page(session: Session) -> None:
    """Let a page read nothing for a while."""
    page = await session.page()
    page.stop_reading()
    await asyncio.sleep(3.0)
    page.read_on()


async def command_in_turn(session: Session) -> None:
    """Change parameters and velocity, push, and play a motion, as a person does."""
    page = await session.page()
    await session.running()
    for parameter in session.rng.sample(page.controls["parameters"], 8):
        if parameter["group"] in ("velocity", "time"):
            continue
        page.send(parameter["name"], parameter["default"])
        await asyncio.sleep(0.05)
    page.send("push", [0.1 * page.controls["max_impulse"], 0.0])
    page.send("velocity.forward", 0.1)
    await asyncio.sleep(0.5)
    page.send("stand")
    page.send("motion", session.rng.choice(("squat", "sway", "wave")))
    await page.settle(20.0)


async def flood(session: Session) -> None:
    """Send thousands of commands as fast as possible."""
    page = await session.page()
    await session.running()
    gains = [p for p in page.controls["parameters"] if p["name"].endswith(".weight")]
    for k in range(3000):
        one = gains[k % len(gains)]
        page.send(one["name"], one["default"])
    await page.settle(20.0)


async def rubbish(session: Session) -> None:
    """Send what is no request, and a message that ends the connection."""
    page = await session.page()
    for text in ("", "{", "[]", "null", '{"control": 1}', '{"control": "x"}', "\0" * 100):
        page.send_text(text)
    page.send("velocity.forward", "fast", valid=False)
    page.send("push", [1e9, float("inf")], valid=False)
    page.send("motion", {"name": "squat", "parameters": {"depth": -1e6}}, valid=False)
    await asyncio.sleep(0.3)
    victim = await Page.open(session.url)
    victim.send_text("x" * (1 << 20))
    await asyncio.sleep(0.5)
    victim.kill()


async def drive_and_vanish(session: Session) -> None:
    """Kill a page that drives; the robot is to stop within half a second."""
    watcher = await session.watcher()
    await session.running()
    driver = await Page.open(session.url)
    driver.send("velocity.forward", 0.1)
    await driver.settle(5.0)
    await asyncio.sleep(1.5)
    session.closed.append(driver)
    driver.kill()
    start = time.monotonic()
    while any(watcher.status.get("velocity", (0.0,))) and time.monotonic() < start + 5.0:
        await asyncio.sleep(0.01)
    session.stops.append(time.monotonic() - start)


async def fall(session: Session) -> None:
    """Push the robot over, and reset it."""
    page = await session.watcher()
    await session.running()
    largest = page.controls["max_impulse"]
    end = time.monotonic() + 10.0
    while page.status.get("mode") == "running" and time.monotonic() < end and not page.lost:
        page.send("push", [0.0, largest])
        await asyncio.sleep(0.4)
    await session.running()
    await page.settle(5.0)


async def save(session: Session) -> None:
    """Save the last seconds as a log."""
    page = await session.watcher()
    now, before = page.status["session"], len(page.saved)
    page.send("save", {"as": "log", "from": max(now - 10.0, 0.0), "to": now}, valid=False)
    end = time.monotonic() + 20.0
    while len(page.saved) == before and time.monotonic() < end:
        await asyncio.sleep(0.1)


async def draw_signals(session: Session) -> None:
    """Ask for the past of many signals."""
    page = await session.page()
    page.send("signals", ["dcm_error", "tick_time"], valid=False)
    await asyncio.sleep(0.5)


def stop_for(module: str, seconds: float) -> Callable[[Session], Awaitable[None]]:
    """Return a fault that stops a process for seconds, as a blocked disk does."""

    async def fault(session: Session) -> None:
        pid = session.children[module]
        os.kill(pid, signal.SIGSTOP)
        try:
            await asyncio.sleep(seconds)
        finally:
            os.kill(pid, signal.SIGCONT)

    return fault


async def nothing(session: Session) -> None:
    """Inject nothing: the same time, for comparison."""
    await asyncio.sleep(1.0)


FAULTS: dict[str, Callable[[Session], Awaitable[None]]] = {
    "page opened and closed": open_and_close,
    "page killed": kill_page,
    "page does not read": stall_page,
    "commands": command_in_turn,
    "3000 commands at once": flood,
    "rubbish": rubbish,
    "page that drives killed": drive_and_vanish,
    "fall and reset": fall,
    "stretch saved": save,
    "signals drawn": draw_signals,
    "log writer stopped for 3 s": stop_for(WRITER, 3.0),
    "page server stopped for 2 s": stop_for(SERVER, 2.0),
    "nothing (for comparison)": nothing,
}


# ---- Sessions ----


async def inject(session: Session, seconds: float) -> None:
    """Inject faults, each kind as often as the others, until the time is over."""
    end = time.monotonic() + seconds
    waiting: list[str] = []
    await session.open_page()
    await session.running()
    while time.monotonic() < end and session.process.poll() is None:
        await asyncio.sleep(session.rng.uniform(0.5, 1.5) * SETTLING)
        if not waiting:
            waiting = session.rng.sample(list(FAULTS), len(FAULTS))
        kind = waiting.pop()
        start = time.monotonic()
        await FAULTS[kind](session)
        session.faults.append(Fault(kind, start, time.monotonic() + AFTER))


async def end(session: Session, ending: str) -> None:
    """End the session by force, or in order."""
    for page in session.pages:
        page.read_on()
        await page.settle(10.0)
    process = session.process
    if ending == "log writer killed":
        os.kill(session.children[WRITER], signal.SIGKILL)
    elif ending == "disk full":
        size = (session.folder / "log.mcap").stat().st_size + LIMIT
        limit = (size, size)
        resource.prlimit(session.children[WRITER], resource.RLIMIT_FSIZE, limit)
    elif ending == "page server killed":
        os.kill(session.children[SERVER], signal.SIGKILL)
    if ending in ("log writer killed", "disk full", "page server killed"):
        session.faults.append(Fault(ending, time.monotonic(), time.monotonic() + 4.0))
        await asyncio.sleep(5.0)
        process.send_signal(signal.SIGTERM)
    else:
        process.send_signal(getattr(signal, ending))
    loop = asyncio.get_running_loop()
    assert process.stdout is not None
    text = await loop.run_in_executor(None, process.stdout.read)
    (session.folder / "report.txt").write_text(text)
    await loop.run_in_executor(None, process.wait)
    for page in session.pages:
        page.kill()
    deadline = time.monotonic() + 20.0
    while any(map(is_running, session.children.values())) and time.monotonic() < deadline:
        await asyncio.sleep(0.1)


async def run_session(session: Session, seconds: float, ending: str) -> Verdict:
    """Run a session to its end; return what was lost."""
    sampling = asyncio.create_task(session.sample_memory())
    try:
        await inject(session, seconds)
        await end(session, ending)
    finally:
        sampling.cancel()
        if session.process.poll() is None:
            session.process.kill()
    pages = [*session.closed, *session.pages]
    left = sorted(name for name, pid in session.children.items() if is_running(pid))
    code = session.process.returncode
    return check_session(session.folder, ending, code, session.ticks(), pages, left, session.html)


# ---- Results ----


@dataclass
class LateTicks:
    """Ticks that ended late by more than a period, in the time of one kind of fault.

    Attributes:
        faults: How often it was injected.
        ticks: Ticks meanwhile.
        late: Those of them that were late.
    """

    faults: int = 0
    ticks: int = 0
    late: int = 0


def late_ticks(session: Session, found: dict[str, LateTicks]) -> None:
    """Count the late ticks of a session by kind of fault; "no fault" is the rest of the time."""
    ticks, dt = session.ticks(), 0.002
    late = ticks["period"] > 2.0 * dt
    rest = np.ones(len(ticks), bool)
    for fault in session.faults:
        within = (ticks["ended"] >= fault.start) & (ticks["ended"] < fault.end)
        rest &= ~within
        one = found.setdefault(fault.kind, LateTicks())
        one.faults += 1
        one.ticks += int(within.sum())
        one.late += int(late[within].sum())
    one = found.setdefault("no fault", LateTicks())
    one.ticks += int(rest.sum())
    one.late += int(late[rest].sum())


def print_late_ticks(found: dict[str, LateTicks]) -> None:
    """Print the late ticks of each kind of fault."""
    print(f"\n{'fault':32}{'times':>6}{'ticks':>9}{'late':>6}{'per 10 000':>12}")
    for kind, one in sorted(found.items(), key=lambda item: item[0] == "no fault"):
        share = 1e4 * one.late / max(one.ticks, 1)
        print(f"{kind:32}{one.faults or '':>6}{one.ticks:9}{one.late:6}{share:12.1f}")
    with_faults = [one for kind, one in found.items() if kind != "no fault"]
    ticks, late = sum(x.ticks for x in with_faults), sum(x.late for x in with_faults)
    rest = found["no fault"]
    expected = rest.late * ticks / max(rest.ticks, 1)
    print(
        f"{late} of {ticks} ticks beside faults were late; as many without faults: "
        f"{expected:.1f} ± {2.0 * np.sqrt(expected + expected**2 / max(rest.late, 1)):.1f}"
    )


def print_memory(session: Session) -> None:
    """Print the memory of each process at ten times, and how fast it grows in the second half."""
    print(
        f"\nmemory of the first session at tenths of its {len(session.ticks()) * 0.002:.0f} s, MB"
    )
    for name, one in session.memory.items():
        values = np.array(one.megabytes)
        known = np.isfinite(values)
        values, times = values[known], np.array(one.time)[known]
        if len(values) < 4:
            continue
        shown = values[np.linspace(0, len(values) - 1, 11).astype(int)]
        half = len(values) // 2
        slope = 60.0 * np.polyfit(times[half:], values[half:], 1)[0]
        opened = np.array(one.descriptors)[known]
        print(
            f"{name:18}" + "".join(f"{value:7.1f}" for value in shown)
            + f"   {slope:+.2f} MB/min, {opened[half:].min()} to {opened[half:].max()} descriptors"
        )  # fmt: skip


async def soak(options: argparse.Namespace, folder: Path) -> int:
    """Run the sessions; return the exit code."""
    rng = random.Random(options.seed)
    end_time = time.monotonic() + 60.0 * options.minutes
    endings: list[str] = []
    verdicts: list[Verdict] = []
    late: dict[str, LateTicks] = {}
    counts: Counter[str] = Counter()
    stops: list[float] = []
    first: Session | None = None
    while time.monotonic() < end_time or first is None:
        seconds = SHORT if first else max(SHORT, 30.0 * options.minutes)
        if not endings:
            endings = rng.sample(ENDINGS, len(ENDINGS))
        ending = endings.pop() if first else "SIGTERM"
        number = len(verdicts) + 1
        session = Session(folder / f"{number}", options.robot, seconds, rng, first is not None)
        try:
            verdict = await run_session(session, seconds, ending)
            late_ticks(session, late)
            if first is None:
                print_memory(session)
        finally:
            session.remove()
        first = first or session
        verdicts.append(verdict)
        counts.update(fault.kind for fault in session.faults)
        stops += session.stops
        print(f"session {number}: {verdict}", flush=True)
        if not verdict.lost and not options.keep:
            shutil.rmtree(session.folder)
    print_late_ticks(late)
    lost = [text for verdict in verdicts for text in verdict.lost]
    sent = sum(verdict.sent for verdict in verdicts)
    print(f"\n{sum(counts.values())} faults in {len(verdicts)} sessions, {sent} commands")
    if stops:
        print(f"a robot whose page vanished stood still after at most {max(stops):.2f} s")
    print("lost: " + ("; ".join(lost) if lost else "nothing"))
    if options.json:
        results = {
            "verdicts": [asdict(one) for one in verdicts],
            "late": {kind: asdict(one) for kind, one in late.items()},
            "faults": counts,
            "stops_s": stops,
            "memory": {name: asdict(one) for name, one in first.memory.items()},
        }
        options.json.write_text(json.dumps(results, indent=1) + "\n")
    return 1 if lost else 0


def main() -> int:
    """Inject faults, and print what was lost."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=5.0, help="default: 5")
    parser.add_argument("--seed", type=int, default=0, help="random seed of the faults")
    parser.add_argument("--robot", default="simple_humanoid", help="default: simple_humanoid")
    parser.add_argument("--keep", type=Path, help="keep the files of all sessions in this folder")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(parents=True)
        return asyncio.run(soak(options, options.keep))
    folder = Path(tempfile.mkdtemp(prefix="soak-"))
    code = asyncio.run(soak(options, folder))
    if code:
        print(f"the files of sessions that lost something are in {folder}")
    else:
        shutil.rmtree(folder)
    return code


if __name__ == "__main__":
    sys.exit(main())
