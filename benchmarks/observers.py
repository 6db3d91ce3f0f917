"""What observers cost the 500 Hz walking loop: viewer, log, ROS 2, live page, and all of them.

The loop is `wbc.run` in real time with the performer's own work in every tick; a walk in MuJoCo is
recorded once and replayed, so that the physics takes no part. Each observer has its audience: a
page that takes every frame, a ROS 2 node that takes joint states and transforms at 50 Hz.
Every cell replays the same walk, in rounds, so that a machine's other work falls on all of them;
ratios are to the loop with nothing, of the same run. Four figures of each tick:

- command: wall time from the measurement to the command, which is what the robot feels. The
  observers' calls come after it; what is more is what their processes do to the machine.
- whole: wall time from one wait for the clock to the next, with bookkeeping and observers.
- CPU: the same in CPU time of the loop's thread, without what it waited for a core. Processes on
  the other core slow it all the same, where cores share caches or are threads of one core: see
  the cell with a process beside it that has nothing to do with the loop and only computes.
- own: CPU time of that tick in the loop with nothing (median over the rounds), and of what the
  observers' calls take in the loop's thread. This the observers cost on any machine.

A tick that begins when the next one is due already is an overrun. Then the cost of ROS 2 messages,
and the time from a slider on the live page to the robot's motion.

    python benchmarks/observers.py                      # about 15 minutes
    python benchmarks/observers.py --rounds 1 --seconds 5 --only log
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
from loop import child, stolen
from replay import Replay, lateness, record
from stopwatch import Stopwatch, timed
from watched import EVERYONE, OBSERVERS, Loop, steady, watched

import wbc
from wbc.motions import Performer

DT = 0.002  # s
NOTHING, NEIGHBOUR = "nothing", "nothing, a busy core"
OBSERVED = {**{name: (name,) for name in OBSERVERS}, "all of them": EVERYONE}
KINDS = ("command", "whole", "CPU", "own")
COMPUTE = "while True: sum(bytearray(200_000))"


@dataclass
class Cell:
    """What the rounds of a cell brought.

    Attributes:
        times: of each round, (3, ticks) wall, CPU and observers' CPU time, s.
        work: of each round, (ticks,) from measurement to command, s.
        late: of each round, (ticks,) s.
        calls: CPU time of each call, s.
        figures: what its observers told, of each round.
        conditions: what the system granted.
        stolen: by the hypervisor, s.
    """

    times: list[np.ndarray] = field(default_factory=list)
    work: list[np.ndarray] = field(default_factory=list)
    late: list[np.ndarray] = field(default_factory=list)
    calls: dict[str, list[float]] = field(default_factory=dict)
    figures: list[dict[str, float]] = field(default_factory=list)
    conditions: str = ""
    stolen: float = 0.0

    def summary(self, nothing: Cell) -> dict[str, Any]:
        """Times in µs, and as ratios to the loop with nothing."""
        line: dict[str, Any] = {}
        for kind, own, base in zip(
            KINDS, self._ticks(nothing), nothing._ticks(nothing), strict=True
        ):
            for q in (50, 99):
                value = float(np.percentile(own, q))
                line[f"{kind} p{q}"] = value
                line[f"{kind} p{q} ratio"] = value / float(np.percentile(base, q))
        late = 1e6 * np.concatenate(self.late)
        waited = 1e6 * np.concatenate([wall - cpu for wall, cpu, _ in self.times])
        line |= {
            "waited p99": float(np.percentile(waited, 99)),
            "late p99": float(np.percentile(late, 99)),
            "overruns": int((late >= 1e6 * DT).sum()),
            "ticks": late.size,
            "stolen s": self.stolen,
        }
        line["calls"] = {
            what: {
                "p50": 1e6 * float(np.median(spent)),
                "p99": 1e6 * float(np.percentile(spent, 99)),
                "per tick": 1e6 * sum(spent) / late.size,
            }
            for what, spent in self.calls.items()
        }
        names = dict.fromkeys(name for figures in self.figures for name in figures)
        line["figures"] = {
            name: float(np.median([f[name] for f in self.figures if name in f])) for name in names
        }
        return {**line, "conditions": self.conditions}

    def _ticks(self, nothing: Cell) -> tuple[np.ndarray, ...]:
        """By kind, µs."""
        wall, cpu, _ = np.concatenate(self.times, axis=1)
        alone = np.median([times[1] for times in nothing.times], axis=0)
        paid = np.median([times[2] for times in self.times], axis=0)
        return tuple(1e6 * x for x in (np.concatenate(self.work), wall, cpu, alone + paid))


class Case:
    """One robot's recorded walk, to be replayed before any observers.

    Args:
        robot: the robot.
        seconds: of the walk.
        speed: of the walk, m/s.
        domain: of ROS 2.
    """

    def __init__(self, robot: wbc.Robot, seconds: float, speed: float, domain: int) -> None:
        self.robot, self.speed, self.domain = robot, speed, domain
        self.walk = record(robot, DT, speed, seconds, Performer(robot, DT))

    @contextlib.contextmanager
    def _loop(self, name: str) -> Iterator[Loop]:
        controller = Performer(self.robot, DT)
        plant = Replay(self.robot, DT, self.walk)
        with contextlib.ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="wbc-observers-"))
            loop = Loop(controller, plant, Path(folder), self.domain)
            if name == NEIGHBOUR:
                stack.enter_context(child(COMPUTE))
            stack.enter_context(watched(loop, OBSERVED.get(name, ())))
            yield loop

    def measure(self, name: str, cell: Cell) -> None:
        """One round of a cell."""
        with self._loop(name) as loop:
            watch, before = Stopwatch(len(self.walk)), stolen()
            timed(loop, watch)
            loop.before_tick.append(steady(loop.controller, (self.speed, 0.0, 0.0)))
            with watch.running():
                report, cell.conditions = loop.run(len(self.walk) * DT, wbc.RealTime())
            if not report.survived:
                raise SystemExit(f"'{name}' is not what was recorded: {report.fell_why}")
            plant = loop.plant
            cell.stolen += stolen() - before
            cell.times.append(watch.times(plant.ticks))
            cell.work.append(plant.commanded - plant.asked)
            cell.late.append(lateness(plant.asked, DT))
            for what, spent in watch.calls.items():
                cell.calls.setdefault(what, []).extend(spent)
        cell.figures.append(loop.figures)


def show(lines: dict[str, dict[str, Any]]) -> None:
    """Print the tables of the cells."""
    heads = [f"{kind} p{q}" for kind in KINDS for q in (50, 99)]
    print(f"{'µs (ratio)':<21}" + "".join(f"{head:>14}" for head in heads))
    for name, line in lines.items():
        texts = [f"{line[h]:.0f} ({line[f'{h} ratio']:.3f})" for h in heads]
        print(f"{name:<21}" + "".join(f"{text:>14}" for text in texts))
    heads = ["waited p99", "late p99", "overruns", "ticks", "stolen s"]
    print(f"\n{'µs':<21}" + "".join(f"{head:>14}" for head in heads))
    for name, line in lines.items():
        print(f"{name:<21}" + "".join(f"{line[head]:>14.6g}" for head in heads))
    for text in dict.fromkeys(line["conditions"] for line in lines.values()):
        print(text)
    for name, line in lines.items():
        if line["calls"] or line["figures"]:
            print(f"\n{name}")
        for what, row in line["calls"].items():
            texts = [f"{head} {value:.1f}" for head, value in row.items()]
            print(f"  {what:<42}µs of CPU: " + ", ".join(texts))
        for what, value in line["figures"].items():
            print(f"  {what:<42}{value:.1f}")


def main() -> None:
    """Measure, print, write the JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each run (default: 20)")
    parser.add_argument("--rounds", type=int, default=5, help="of all cells (default: 5)")
    parser.add_argument("--speed", type=float, default=0.3, help="of the walk, m/s (default: 0.3)")
    parser.add_argument("--only", action="append", choices=[NEIGHBOUR, *OBSERVED])
    parser.add_argument("--repeats", type=int, default=20, help="of the slider (default: 20)")
    parser.add_argument("--messages", type=int, default=2000, help="of ROS 2 (default: 2000)")
    parser.add_argument("--domain", type=int, default=94, help="of ROS 2 (default: 94)")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()

    robot = wbc.load(options.robot)
    case = Case(robot, options.seconds, options.speed, options.domain)
    chosen = [NOTHING, *(options.only or (NEIGHBOUR, *OBSERVED))]
    cells = {name: Cell() for name in chosen}
    for done in range(options.rounds):
        print(f"round {done + 1} of {options.rounds}", file=sys.stderr)
        first = done % len(chosen)  # another one each time
        for name in chosen[first:] + chosen[:first]:
            case.measure(name, cells[name])
    told: dict[str, Any] = {"robot": robot.name, "processors": os.cpu_count()}
    told |= {"kernel": platform.release(), "load": os.getloadavg()}
    print(", ".join(f"{key} {value}" for key, value in told.items()))
    told["cells"] = {name: cell.summary(cells[NOTHING]) for name, cell in cells.items()}
    show(told["cells"])
    if options.messages:
        told["messages"] = ros2_benchmark.publishing(options.domain + 1, options.messages)
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
