"""Evaluates the motions of each robot in simulation: the table of motions in the README.

Every run is in MuJoCo with physics at 1 kHz, friction 0.8, the URDF's torque limits, noisy
sensors and the estimator in the loop. CoM errors, slips, hands and flights are measured on the
true state, relative to the soles. A run passes if the robot does not fall, the figure is within
its bound, no QP fails, no torque and no joint position exceeds its limit (by 1e-3 rad), no sole
slips by more than 5 mm, no motion is aborted, and the run ends in time. A motion that is refused
before it starts fails too, except the jump of a robot whose limits rule it out. The positions to
reach are those of sampled postures of both arms; how many postures were sampled, and why others
were rejected, is printed below the table. Every position counts.

    python benchmarks/motions.py                     # all robots, 5 seeds
    python benchmarks/motions.py --robot g1 --seeds 1 --motion squat
    python benchmarks/motions.py --servos            # joints driven by servos, not by torques
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import wbc
from wbc.errors import MotionError
from wbc.motions import Motion
from wbc.motions.demo import Demo
from wbc.motions.jump import Jump
from wbc.motions.one_leg import OneLeg
from wbc.motions.reach import Reach
from wbc.motions.squat import Squat
from wbc.motions.sway import Sway
from wbc.motions.wave import Wave
from wbc.runtime.report import Report
from wbc.sim import JointServos
from wbc.trials import run_motions

ROBOTS = ("talos", "g1", "simple_humanoid")
WALK = {"g1": 0.2}  # m/s; 0.3 for the others
ONE_LEG_BOUND = {"talos": 6.0}  # mm
CLEARANCE = 30.0  # mm
MAY_REFUSE_JUMP = ("talos", "g1")  # their limits may rule out that jump
WAVE_TIME = 8.0  # s
SERVO_LATENCY = 0.002  # s
REACHES = 40  # pairs of positions per seed
MARKS = ("<!-- motions:begin -->", "<!-- motions:end -->")


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        name: the first column.
        motions: Returns the motions to play for a robot name and a seed.
        figure: Returns the measured figure; NaN if there is none.
        unit: Unit of the figure.
        worst: Reduces the figures of several seeds to the worst one.
        within_bound: Returns whether a robot's figure is within its bound.
        complete: Returns whether the report shows that the robot completed the motion.
        may_be_refused: Whether a robot's limits may rule the motion out.
    """

    name: str
    motions: Callable[[str, int], list[Motion]]
    figure: Callable[[Report], float] = lambda report: math.nan
    unit: str = ""
    worst: Callable[[list[float]], float] = max
    within_bound: Callable[[str, float], bool] = lambda robot, figure: True
    complete: Callable[[str, Report], bool] = lambda robot, report: True
    may_be_refused: bool = False

    def passed(self, robot: str, report: Report) -> bool:
        """Return whether a run passes."""
        slip = math.inf if report.foot_slip_mm is None else report.foot_slip_mm
        return (
            report.survived
            and not report.aborted_motions
            and self.complete(robot, report)
            and self.within_bound(robot, self.figure(report))
            and report.qp_failures == 0
            and report.joint_limit_excess_rad <= 1e-3
            and report.torque_excess_nm <= 0.0
            and slip <= 5.0
        )


def com_error(report: Report) -> float:
    """Return the CoM error of a run, mm rms."""
    return math.inf if report.com_error_rms_mm is None else report.com_error_rms_mm


def clearance(report: Report) -> float:
    """Return the greatest clearance of the lower sole in flight, mm."""
    return max((flight.clearance_mm for flight in report.flights), default=0.0)


def reached(report: Report) -> float:
    """Return the share of the hands' targets that were reached within 1 cm, %."""
    return 100.0 * report.targets_reached / max(report.targets, 1)


ROWS = (
    Row(
        "sway 4 cm, 0.5 Hz (circle, then eight): CoM error rms ≤ 6 mm",
        lambda robot, seed: [Sway(), Sway(shape="eight")],
        com_error,
        "mm",
        within_bound=lambda robot, error: error <= 6.0,
    ),
    Row(
        "squat 10 % of leg length, 0.5 Hz: CoM error rms ≤ 5 mm",
        lambda robot, seed: [Squat()],
        com_error,
        "mm",
        within_bound=lambda robot, error: error <= 5.0,
    ),
    Row(
        "wave while walking 0.3 m/s (g1 0.2), 8 s: no fall",
        lambda robot, seed: [Wave(walk=WALK.get(robot, 0.3), seconds=WAVE_TIME)],
        complete=lambda robot, report: (
            report.displacement_m[0] >= 0.8 * WALK.get(robot, 0.3) * WAVE_TIME
        ),
    ),
    Row(
        "one leg, each side 5 s, pushed 0.05 N·s/kg: no fall (talos: CoM error rms ≤ 6 mm)",
        lambda robot, seed: [OneLeg(towards=(90.0, 0.0, 180.0, 270.0, 45.0)[seed % 5])],
        com_error,
        "mm",
        within_bound=lambda robot, error: error <= ONE_LEG_BOUND.get(robot, math.inf),
    ),
    Row(
        f"reach, {REACHES} × 2 random positions per seed: ≥ 98 % within 1 cm, no fall",
        lambda robot, seed: [Reach(random=REACHES, place_seed=seed)],
        reached,
        "%",
        worst=lambda shares: sum(shares) / len(shares),
        complete=lambda robot, report: report.targets == 2 * REACHES,
    ),
    Row(
        "jump: both soles clear ≥ 3 cm, lands standing",
        lambda robot, seed: [Jump()],
        clearance,
        "mm",
        worst=min,
        within_bound=lambda robot, height: height >= CLEARANCE,
        may_be_refused=True,
    ),
    Row(
        "demo, everything in a row: no fall",
        lambda robot, seed: [Demo()],
        complete=lambda robot, report: not any(n.startswith("left out") for n in report.notes),
    ),
)


def trial(job: tuple[str, int, int, bool]) -> tuple[str, int, int, Report | str]:
    """Run one trial; return its report, or the error message if the motion is refused."""
    name, index, seed, with_servos = job
    robot = wbc.load(name)
    actuation = {"servos": JointServos(), "latency": SERVO_LATENCY} if with_servos else {}
    try:
        report = run_motions(robot, ROWS[index].motions(name, seed), seed, **actuation)
    except MotionError as refusal:
        return name, index, seed, str(refusal)
    return name, index, seed, report


def main() -> int:
    """Run the trials, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--robot",
        action="append",
        choices=ROBOTS,
        help="robot to run; may be repeated (default: all)",
    )
    parser.add_argument("--motion", default="", help="only rows whose name contains this")
    parser.add_argument("--seeds", type=int, default=5, help="runs per cell (default: %(default)s)")
    parser.add_argument(
        "--servos",
        action="store_true",
        help="joints are servos with soft gains, 2 ms of delay, friction and a backlash of 0.5°",
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="write all reports here")
    parser.add_argument("--readme", type=Path, help="update the table in this file")
    args = parser.parse_args()
    robots = args.robot or ROBOTS
    jobs = [
        (name, index, seed, args.servos)
        for index, row in enumerate(ROWS)
        if args.motion in row.name
        for name in robots
        for seed in range(args.seeds)
    ]
    results: dict[tuple[int, str], list[Report | str]] = {}
    begun = time.perf_counter()
    with ProcessPoolExecutor(args.jobs) as pool:
        for name, index, seed, result in pool.map(trial, jobs):
            results.setdefault((index, name), []).append(result)
            print(line(ROWS[index], name, seed, result), file=sys.stderr, flush=True)
    text = table(results, robots)
    print(text)
    for (index, name), some in results.items():
        notes = [r.notes[0] for r in some if not isinstance(r, str) and r.targets and r.notes]
        if ROWS[index].unit == "%":
            print("\n".join(f"{name}, seed {s}: {note}" for s, note in enumerate(notes)))
    print(f"\n{len(jobs)} runs in {time.perf_counter() - begun:.0f} s")
    if args.readme:
        head, rest = args.readme.read_text(encoding="utf-8").split(MARKS[0])
        tail = rest.split(MARKS[1])[1]
        args.readme.write_text(f"{head}{MARKS[0]}\n{text}\n{MARKS[1]}{tail}", encoding="utf-8")
    if args.json:
        rows = [
            {
                "row": ROWS[i].name,
                "robot": n,
                "seed": s,
                **(asdict(r) if not isinstance(r, str) else {"refused": r}),
            }
            for (i, n), reports in results.items()
            for s, r in enumerate(reports)
        ]
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if all(cell(ROWS[i], n, r)[1] for (i, n), r in results.items()) else 1


def line(row: Row, robot: str, seed: int, result: Report | str) -> str:
    """Return the progress line of one run."""
    head = f"{robot:16} {row.name.split(':')[0][:44]:44} seed {seed}"
    if isinstance(result, str):
        return f"refused {head}  {result}"
    mark = "ok   " if row.passed(robot, result) else "FAIL "
    figure = "" if not row.unit else f"{row.figure(result):6.1f} {row.unit}"
    slip = result.foot_slip_mm or 0.0
    failure = result.explanation[:80] if result.qp_failures else ""
    why = result.fell_why or ", ".join(f"aborted {m}" for m in result.aborted_motions) or failure
    return (
        f"{mark} {head}  {figure}  CoM {com_error(result):.1f} mm, slip {slip:.1f} mm, torque "
        f"{100 * result.torque_peak_ratio:.0f} %, joints {result.joint_limit_excess_rad:.0e}  {why}"
    )


def cell(row: Row, robot: str, results: list[Report | str]) -> tuple[str, bool]:
    """Return the text of a cell, and whether all its runs passed."""
    reports = [r for r in results if not isinstance(r, str)]
    if not reports:
        return f"refused: {results[0]}", row.may_be_refused and robot in MAY_REFUSE_JUMP
    passed = sum(row.passed(robot, r) for r in reports)
    good = passed == len(reports)
    if not row.unit:
        return f"{passed}/{len(reports)}", good
    figure = row.worst([row.figure(r) for r in reports])
    if row.unit == "%":
        good = good and figure >= 98.0
    return f"{figure:.1f} {row.unit} ({passed}/{len(reports)})", good


def table(results: dict[tuple[int, str], list[Report | str]], robots: tuple[str, ...]) -> str:
    """Return a Markdown table: one row per motion, then the extremes of all runs."""
    lines = [f"| | {' | '.join(robots)} |", f"| --- |{' --- |' * len(robots)}"]
    for index, row in enumerate(ROWS):
        cells = [results.get((index, name)) for name in robots]
        if any(cells):
            texts = [cell(row, n, r)[0] if r else "" for n, r in zip(robots, cells, strict=True)]
            lines.append(f"| {row.name} | {' | '.join(texts)} |")
    extremes: tuple[tuple[str, str, Callable[[Report], float]], ...] = (
        ("beyond joint limits, rad", "{:.0e}", lambda r: r.joint_limit_excess_rad),
        ("beyond torque limits, N·m", "{:.0f}", lambda r: max(r.torque_excess_nm, 0.0)),
        ("QP failures", "{:.0f}", lambda r: r.qp_failures),
        ("foot slip, jump included, mm", "{:.1f}", lambda r: r.foot_slip_mm or 0.0),
    )
    for what, form, of in extremes:
        texts = []
        for name in robots:
            reports = [
                r
                for (_, robot), some in results.items()
                for r in some
                if robot == name and not isinstance(r, str)
            ]
            texts.append(form.format(max(of(r) for r in reports)) if reports else "")
        lines.append(f"| worst of all runs: {what} | {' | '.join(texts)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
