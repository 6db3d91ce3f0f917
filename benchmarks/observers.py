"""What observers cost the 500 Hz walking loop: viewer, log, ROS 2, live page, and all of them.

The loop is `wbc.run` in real time with the player's own work in every tick; a walk in MuJoCo is
recorded once and replayed, so that the physics takes no part. Each observer has a client: a
page that takes every frame, a ROS 2 node that takes joint states and transforms at 50 Hz.

All of them are there from the beginning, and are switched on and off while the loop runs: every
fifth of a second another cell's turn comes, in random order, all cells once in each block of turns.
An observer that is off is not called, and its processes and its client's are stopped. So every cell
is measured in the same process, in the same memory and at the same time: two runs of one and the
same loop differ by a tenth and more on a shared machine. The first ticks after switching do not
count. Three figures of each tick, with their ratio to the ticks with nothing and the 95 % interval
of that ratio (bootstrap over the blocks):

- command: wall time from the measurement to the command, which is what the robot feels.
- whole: wall time from one wait for the clock to the next, with bookkeeping and observers.
- CPU: the same in CPU time of the loop's thread.

"A busy core" is a process that has nothing to do with the loop and only computes. A tick that
begins when the next one is due already is an overrun. In the end all four watch undisturbed, for
the display rates and what their processes take; then the cost of ROS 2 messages, and the time from
a slider on the live page to the robot's motion.

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
NOTHING, BUSY = "nothing", "a busy core"
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
    """What the turns of a cell brought.

    Attributes:
        times: of each block's turn, (3, ticks) from measurement to command, wall and CPU time, s.
        late: likewise, (ticks,) s.
    """

    times: list[np.ndarray] = field(default_factory=list)
    late: list[np.ndarray] = field(default_factory=list)

    def summary(self, nothing: Cell, rng: np.random.Generator) -> dict[str, Any]:
        """Times in µs, and as ratios to the loop with nothing."""
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
    """One robot's recorded walk, to be replayed before observers.

    Args:
        robot: the robot.
        seconds: of the walk.
        speed: of the walk, m/s.
        domain: of ROS 2.
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
            raise SystemExit(f"the walk is not what was recorded: {report.fell_why}")

    def measure(self, cells: dict[str, Cell], rng: np.random.Generator) -> None:
        """One round: the whole walk, with turns of all cells."""
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
                if within == 0 and turn > 0:  # in the first turn all are called once
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
            # The last tick of a turn has the switching in it.
            counted = slice(turn * TURN + SETTLING, (turn + 1) * TURN - 1)
            cells[name].times.append(kinds[:, counted])
            cells[name].late.append(lateness(plant.measured_at[counted], DT))

    def undisturbed(self, seconds: float, names: tuple[str, ...]) -> dict[str, Any]:
        """What the observers tell when they watch all the time, and their calls in µs of CPU."""
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


def show_undisturbed(told: dict[str, Any]) -> None:
    """Print what the observers told."""
    for what, row in told["calls"].items():
        texts = [f"{head} {value:.1f}" for head, value in row.items()]
        print(f"  {what:<40}µs of CPU: " + ", ".join(texts))
    for what, value in told["figures"].items():
        print(f"  {what:<40}{value:.1f}")


def main() -> None:
    """Measure, print, write the JSON."""
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
    told: dict[str, Any] = {"robot": robot.name, "processors": os.cpu_count()}
    told |= {"kernel": platform.release(), "load": os.getloadavg(), "stolen s": stolen() - before}
    print(", ".join(f"{key} {value}" for key, value in told.items()))
    print(case.conditions)
    told["cells"] = {name: cell.summary(cells[NOTHING], rng) for name, cell in cells.items()}
    show(told["cells"])
    save(told, options.json)
    if options.undisturbed:
        observers = dict.fromkeys(n for cell in cells for n in CELLS[cell] if n != BUSY)
        several = "ROS 2 at 500 Hz" in observers and "ROS 2" in observers
        names = tuple(n for n in observers if not (several and n == "ROS 2 at 500 Hz"))
        told["undisturbed"] = case.undisturbed(options.undisturbed, names)
        print(f"\nundisturbed: {', '.join(names)}")
        show_undisturbed(told["undisturbed"])
        save(told, options.json)
    if options.messages:
        told["messages"] = ros2_benchmark.publishing(options.domain + 2, options.messages)
        title = "publishing from the node's process, µs of CPU per message"
        ros2_benchmark.show(title, told["messages"])
        save(told, options.json)
    if options.repeats:
        told["slider"], _ = live_benchmark.slider(robot, options.repeats)
        ros2_benchmark.show("live page", told["slider"])
        save(told, options.json)


def save(told: dict[str, Any], path: Path | None) -> None:
    """Write the figures that are there, if they are wanted."""
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
