"""Time that a fresh process needs for imports, for loading a robot and for the first tick.

Every case is measured in fresh processes, in turn (A B C, A B C, …), so that other load on the
machine affects all of them; the median counts. Python's bytecode exists already, as after pip. A
"cold" case finds no compiled kernels on disk, as after an installation; a "warm" one does.

    python benchmarks/startup.py
    python benchmarks/startup.py --repeat 21 --cold 5 --json out/startup.json
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
CALIBRATION = "import pinocchio"

EVERYTHING = """
import wbc
for name in wbc.__all__:
    if name[0].isupper() or name in ("load", "run"):
        getattr(wbc, name)
"""

LOAD = """
import wbc
begin()
wbc.load({robot!r})
end()
"""

TICK = """
import wbc
robot = wbc.load({robot!r})
state = robot.standing()
begin()
controller = wbc.WholeBodyController(robot, dt=0.002)
controller.add(wbc.ComTask(weight=1000.0, kp=40.0))
controller.add(wbc.OrientationTask(robot.torso, weight=20.0, kp=80.0))
controller.add(wbc.PostureTask(robot, weight=0.3, kp=60.0))
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
command = controller.step(state)
end()
assert command.status is wbc.Status.OK, command.explanation
"""

# The child process measures CPU and wall time between `begin` and `end`.
TIMER = """
import time
def begin():
    global cpu, wall
    cpu, wall = time.process_time(), time.perf_counter()
def end():
    print("\\nPART", time.process_time() - cpu, time.perf_counter() - wall)
"""


@dataclass(frozen=True)
class StartupCase:
    """One line of the table.

    Attributes:
        name: the first column.
        code: Python code, run by `python -c`.
        cold: whether the process finds no compiled kernels.
        part: name of the part between `begin()` and `end()`, which is timed separately.
    """

    name: str
    code: str
    cold: bool = False
    part: str = ""


@dataclass
class StartupTimes:
    """CPU and wall times of the repeats of a case, and of its part, s."""

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    part_cpu: list[float] = field(default_factory=list)
    part_wall: list[float] = field(default_factory=list)

    def add(self, other: StartupTimes) -> None:
        """Append the times of another."""
        for name, values in vars(other).items():
            getattr(self, name).extend(values)


def startup_cases(robot: str) -> list[StartupCase]:
    """Return the lines of the table."""
    return [
        StartupCase("python", "pass"),
        StartupCase("import numpy", "import numpy"),
        StartupCase(CALIBRATION, CALIBRATION),
        StartupCase("import wbc", "import wbc"),
        StartupCase("import wbc, all of its core", EVERYTHING),
        StartupCase(f'wbc.load("{robot}")', LOAD.format(robot=robot), part="load"),
        StartupCase("first tick, warm", TICK.format(robot=robot), part="controller and tick"),
        StartupCase(
            "first tick, cold", TICK.format(robot=robot), cold=True, part="controller and tick"
        ),
    ]


def run(case: StartupCase, environment: Mapping[str, str]) -> StartupTimes:
    """Run a case once, in a fresh process.

    Raises:
        SystemExit: the process failed; it has printed why.
    """
    timer = TIMER if case.part else ""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", timer + case.code],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"'{case.name}' failed")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    parts = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("PART")]
    return StartupTimes(
        [cpu], [wall], [float(part[0]) for part in parts], [float(part[1]) for part in parts]
    )


def environment(kernels: Path | None) -> dict[str, str]:
    """Return the environment of a child: one thread, this checkout.

    Args:
        kernels: folder for compiled kernels; None for the usual one.
    """
    inherited = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    threads = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    return {
        **inherited,
        **dict.fromkeys(threads, "1"),
        "PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH")))),
        **({"NUMBA_CACHE_DIR": str(kernels)} if kernels else {}),
    }


def measure(chosen: list[StartupCase], repeat: int, cold: int) -> dict[str, StartupTimes]:
    """Measure each case `repeat` times, cold ones `cold` times."""
    times = {case.name: StartupTimes() for case in chosen}
    with tempfile.TemporaryDirectory(prefix="wbc-startup-") as name:
        warm = environment(None)
        for case in chosen:
            run(case, warm)  # bytecode, kernels and the disk's cache; not counted
        for k in range(max(repeat, cold)):
            for case in chosen:
                if k >= (cold if case.cold else repeat):
                    continue
                cold_kernels = Path(name) / f"kernels-{k}"
                times[case.name].add(run(case, environment(cold_kernels) if case.cold else warm))
    return times


def median(values: list[float]) -> float | None:
    """Return the median, s, or None without values."""
    return float(np.median(values)) if values else None


def table(
    chosen: list[StartupCase], times: dict[str, StartupTimes]
) -> list[dict[str, float | str | None]]:
    """Return medians, s, and the ratio of CPU time to importing Pinocchio, by case."""
    unit = median(times[CALIBRATION].cpu) or np.nan
    lines: list[dict[str, float | str | None]] = []
    for case in chosen:
        figures = times[case.name]
        if not figures.cpu:
            continue
        cpu = float(np.median(figures.cpu))
        lines.append(
            {
                "what": case.name,
                "runs": len(figures.cpu),
                "cpu_s": cpu,
                "cpu_min_s": min(figures.cpu),
                "wall_s": median(figures.wall),
                "ratio": cpu / unit,
                "part": case.part,
                "part_cpu_s": median(figures.part_cpu),
                "part_wall_s": median(figures.part_wall),
            }
        )
    return lines


def show(lines: list[dict[str, float | str | None]]) -> None:
    """Print the table."""
    print(
        f"{'fresh process':<30}{'CPU s':>8}{'least':>8}{'wall s':>8}"
        f"{'× pinocchio':>13}   of which, CPU / wall s"
    )
    for line in lines:
        text = f"{line['what']:<30}{line['cpu_s']:>8.3f}{line['cpu_min_s']:>8.3f}"
        text += f"{line['wall_s']:>8.3f}{line['ratio']:>13.2f}"
        if line["part"] and line["part_cpu_s"] is not None:
            text += f"   {line['part']}: {line['part_cpu_s']:.3f} / {line['part_wall_s']:.3f}"
        print(text)


def main() -> None:
    """Measure, print the table, write the JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos", help="robot to load (default: %(default)s)")
    parser.add_argument("--repeat", type=int, default=9, help="repeats (default: %(default)s)")
    parser.add_argument(
        "--cold", type=int, default=3, help="repeats without kernels (default: %(default)s)"
    )
    parser.add_argument("--only", action="append", metavar="TEXT", help="only rows containing this")
    parser.add_argument("--json", type=Path, help="write the table and all times to this file")
    options = parser.parse_args()
    chosen = [case for case in startup_cases(options.robot) if options.cold > 0 or not case.cold]
    texts = [CALIBRATION, *(options.only or [""])]
    chosen = [case for case in chosen if any(text in case.name for text in texts)]
    times = measure(chosen, options.repeat, options.cold)
    lines = table(chosen, times)
    show(lines)
    if options.json:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        every = {name: asdict(figures) for name, figures in times.items()}
        text = json.dumps({"robot": options.robot, "rows": lines, "times": every}, indent=1)
        options.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
