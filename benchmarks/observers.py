"""Measures the load of the observers on the 500 Hz walking loop, separately and combined.

The loop is `wbc.run` in real time with the motion player's computation in every tick; a walk in
MuJoCo is recorded once and replayed, which excludes the physics. Each observer has a client: a
page that receives every frame, or a ROS 2 node that receives joint states and transforms at 50 Hz.

All observers start with the loop and are switched on and off while it runs: every 0.2 s another
combination (cell) takes its turn, in random order, each cell once per block. An observer that is
off is not called, and its processes and its client are stopped. Every cell is therefore measured in
the same process, memory and time span: on a shared machine two runs of the same loop differ by 10 %
and more. The first ticks after switching are excluded. Three times are measured per tick, with
their ratio to the ticks without observers and its 95 % interval (bootstrap over the blocks):

- command: wall time from the measurement to the command, the delay of the command on a robot.
- whole: wall time from one wait for the clock to the next, with bookkeeping and observers.
- CPU: the same in CPU time of the loop's thread.

"A busy core" is an unrelated process that only computes. A tick that begins when the next one is
already due is an overrun. At the end all four observers run without switching, for their frame
rates and the CPU time of their processes; then the CPU time of ROS 2 messages and the latency from
a slider on the live page to the robot's motion are measured.

    python benchmarks/observers.py                      # about 8 minutes
    python benchmarks/observers.py --rounds 1 --seconds 20 --only log
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import contextlib
import json
import platform
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import live as live_benchmark
import numpy as np
import ros2 as ros2_benchmark
from loop import neighbour, stolen
from shared.observed_loop import OBSERVERS, AttachedObserver, ObservedLoop, observed
from shared.replay import Replay, lateness, record
from shared.tick_timer import TickTimer

import wbc
from wbc.motions import MotionPlayer

DT = 0.002  # s
TURN = 100  # ticks of a cell at a time
SETTLING = 15  # ticks after switching that do not count
NOTHING, BUSY = "no observers", "a busy core"
CELLS = {
    NOTHING: (),
    BUSY: (BUSY,),
    **{name: (name,) for name in OBSERVERS},
    "viewer, log, ROS 2": ("viewer", "log", "ROS 2"),
    "these and the page": ("viewer", "log", "ROS 2", "live page"),
}
KINDS = ("command", "whole", "CPU")


@dataclass
class Cell:
    """The times measured in the turns of a cell.

    Attributes:
        times: of each block's turn, (3, ticks) from measurement to command, wall and CPU time, s.
        late: likewise, (ticks,) s.
    """

    times: list[np.ndarray] = field(default_factory=list)
    late: list[np.ndarray] = field(default_factory=list)

    def summary(self, nothing: Cell, rng: np.random.Generator) -> dict[str, Any]:
        """Return times, µs, and their ratios to the loop without observers."""
        own, base = np.array(self.times), np.array(nothing.times)
        line: dict[str, Any] = {}
        for i, kind in enumerate(KINDS):
            for q in (50, 99):
                name = f"{kind} p{q}"
                line[name] = 1e6 * float(np.percentile(own[:, i], q))
                line[f"{name} ratio"] = _ratio(own[:, i], base[:, i], q)
                blocks = (rng.integers(len(own), size=len(own)) for _ in range(300))
                drawn = [_ratio(own[b, i], base[b, i], q) for b in blocks]
                line[f"{name} interval"] = np.percentile(drawn, (2.5, 97.5)).tolist()
        late = np.concatenate(self.late)
        line |= {
            "late p99": 1e6 * float(np.percentile(late, 99)),
            "overruns": int((late >= DT).sum()),
            "ticks": late.size,
        }
        return line


def _ratio(own: np.ndarray, base: np.ndarray, q: float) -> float:
    return float(np.percentile(own, q) / np.percentile(base, q))


class Case:
    """The recorded walk of a robot, replayed with observers attached.

    Args:
        robot: Robot that walks.
        seconds: Duration of the walk, s.
        speed: Speed of the walk, m/s.
        domain: ROS 2 domain.
    """

    def __init__(self, robot: wbc.Robot, seconds: float, speed: float, domain: int) -> None:
        self.robot, self.speed, self.domain = robot, speed, domain
        self.walk = record(robot, DT, speed, seconds, MotionPlayer(robot, DT))
        self.conditions = ""

    @contextlib.contextmanager
    def _loop(self, names: tuple[str, ...]) -> Iterator[ObservedLoop]:
        plant = Replay(self.robot, DT, self.walk)
        with tempfile.TemporaryDirectory(prefix="wbc-observers-") as folder:
            loop = ObservedLoop(MotionPlayer(self.robot, DT), plant, Path(folder), self.domain)
            loop.velocity = (self.speed, 0.0, 0.0)
            with observed(loop, tuple(name for name in names if name != BUSY)):
                yield loop

    def _run(self, loop: ObservedLoop, ticks: int) -> None:
        report, self.conditions = loop.run(ticks * DT, wbc.RealTime())
        if not report.survived:
            raise SystemExit(f"the replay deviates from the recorded walk: {report.fell_why}")

    def measure(self, cells: dict[str, Cell], rng: np.random.Generator) -> None:
        """Run one round: the whole walk, with turns of all cells."""
        names = list(cells)
        watch = TickTimer(len(self.walk))
        blocks = (len(self.walk) // TURN - 1) // len(names)
        if blocks < 1:
            raise SystemExit(f"{len(self.walk) * DT} s are too short for {len(names)} turns")
        turns = [names[i] for _ in range(blocks) for i in rng.permutation(len(names))]
        with contextlib.ExitStack() as stack:
            everyone = dict.fromkeys(n for cell in names for n in CELLS[cell])
            loop = stack.enter_context(self._loop(tuple(everyone)))
            if BUSY in names:
                loop.observers[BUSY] = AttachedObserver((stack.enter_context(neighbour()),))

            def switch(_: float) -> None:
                turn, within = divmod(loop.plant.ticks, TURN)
                if within == 0 and turn > 0:  # in the first turn every observer is called once
                    wanted = CELLS[turns[turn - 1]] if turn <= len(turns) else ()
                    for name, observer in loop.observers.items():
                        observer.switch(name in wanted)

            loop.before_tick = switch
            with watch.running():
                self._run(loop, len(self.walk))
        self._keep(cells, turns, watch, loop.plant)

    def _keep(
        self, cells: dict[str, Cell], turns: list[str], watch: TickTimer, plant: Replay
    ) -> None:
        wall, cpu = watch.times(plant.ticks)
        kinds = np.array([plant.commanded_at - plant.measured_at, wall, cpu])
        for turn, name in enumerate(turns, 1):
            # The last tick of a turn includes the switching.
            counted = slice(turn * TURN + SETTLING, (turn + 1) * TURN - 1)
            cells[name].times.append(kinds[:, counted])
            cells[name].late.append(lateness(plant.measured_at[counted], DT))

    def undisturbed(self, seconds: float, names: tuple[str, ...]) -> dict[str, Any]:
        """Return the observers' figures without switching, and the CPU time of their calls, µs."""
        ticks = min(round(seconds / DT), len(self.walk))
        watch = TickTimer(ticks)
        with self._loop(names) as loop, watch.running():
            loop.wrap = watch.wrap
            self._run(loop, ticks)
        calls = {
            what: {
                "p50": 1e6 * float(np.median(spent)),
                "p99": 1e6 * float(np.percentile(spent, 99)),
                "per tick": 1e6 * sum(spent) / ticks,
            }
            for what, spent in watch.calls.items()
        }
        return {"figures": loop.figures, "calls": calls}


def show(lines: dict[str, dict[str, Any]]) -> None:
    """Print the tables of the cells."""
    for kind in KINDS:
        heads = [f"{kind} p{q}" for q in (50, 99)]
        print(f"\n{'µs (ratio, 95 % interval)':<26}" + "".join(f"{head:>30}" for head in heads))
        for name, line in lines.items():
            texts = []
            for head in heads:
                low, high = line[f"{head} interval"]
                ratio = line[f"{head} ratio"]
                texts.append(f"{line[head]:.0f} ({ratio:.3f}, {low:.3f} to {high:.3f})")
            print(f"{name:<26}" + "".join(f"{text:>30}" for text in texts))
    heads = ["late p99", "overruns", "ticks"]
    print(f"\n{'µs':<26}" + "".join(f"{head:>12}" for head in heads))
    for name, line in lines.items():
        print(f"{name:<26}" + "".join(f"{line[head]:>12.6g}" for head in heads))


def show_undisturbed(results: dict[str, Any]) -> None:
    """Print the observers' CPU times and figures."""
    for what, row in results["calls"].items():
        texts = [f"{head} {value:.1f}" for head, value in row.items()]
        print(f"  {what:<40}µs of CPU: " + ", ".join(texts))
    for what, value in results["figures"].items():
        print(f"  {what:<40}{value:.1f}")


def main() -> None:
    """Run the measurements, print the results and write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each round (default: 60)")
    parser.add_argument("--rounds", type=int, default=4, help="of all cells (default: 4)")
    parser.add_argument("--speed", type=float, default=0.3, help="of the walk, m/s (default: 0.3)")
    parser.add_argument(
        "--only", action="append", choices=[name for name in CELLS if name != NOTHING]
    )
    parser.add_argument("--undisturbed", type=float, default=20.0, help="s in the end (default 20)")
    parser.add_argument("--repeats", type=int, default=20, help="of the slider (default: 20)")
    parser.add_argument("--messages", type=int, default=2000, help="of ROS 2 (default: 2000)")
    parser.add_argument("--domain", type=int, default=94, help="of ROS 2 (default: 94)")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()

    robot = wbc.load(options.robot)
    rng = np.random.default_rng(0)
    case = Case(robot, options.seconds, options.speed, options.domain)
    cells = {name: Cell() for name in CELLS if name in (options.only or CELLS) or name == NOTHING}
    before = stolen()
    for done in range(options.rounds):
        print(f"round {done + 1} of {options.rounds}", file=sys.stderr)
        case.measure(cells, rng)
    results: dict[str, Any] = {"robot": robot.name, "processors": os.cpu_count()}
    results |= {
        "kernel": platform.release(),
        "load": os.getloadavg(),
        "stolen s": stolen() - before,
    }
    print(", ".join(f"{key} {value}" for key, value in results.items()))
    print(case.conditions)
    results["cells"] = {name: cell.summary(cells[NOTHING], rng) for name, cell in cells.items()}
    show(results["cells"])
    save(results, options.json)
    if options.undisturbed:
        observers = dict.fromkeys(n for cell in cells for n in CELLS[cell] if n != BUSY)
        several = "ROS 2 at 500 Hz" in observers and "ROS 2" in observers
        names = tuple(n for n in observers if not (several and n == "ROS 2 at 500 Hz"))
        results["undisturbed"] = case.undisturbed(options.undisturbed, names)
        print(f"\nundisturbed: {', '.join(names)}")
        show_undisturbed(results["undisturbed"])
        save(results, options.json)
    if options.messages:
        results["messages"] = ros2_benchmark.publishing(options.domain + 2, options.messages)
        title = "publishing from the node's process, µs of CPU per message"
        ros2_benchmark.show(title, results["messages"])
        save(results, options.json)
    if options.repeats:
        results["slider"], _ = live_benchmark.slider(robot, options.repeats)
        ros2_benchmark.show("live page", results["slider"])
        save(results, options.json)


def save(results: dict[str, Any], path: Path | None) -> None:
    """Write the results so far to `path`, if it is given."""
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
