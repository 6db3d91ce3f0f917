"""Measures how the tick time grows with the numbers of joints, contacts and tasks.

Synthetic humanoids (`shared/synthetic.py`) sway on their feet: the controller's own accelerations,
integrated, are the plant. The states are recorded, and replayed by a fresh controller several
times over; of each tick the least CPU time counts, since other work on the machine only ever adds
to it. Three sweeps, one thing changed in each:

- joints: 20 to 100, two soles, four tasks (centre of mass, torso, angular momentum, posture);
- contacts: none to four surfaces (soles, then hands) of a robot of 30 joints, four tasks;
- tasks: 1 to 16 of a robot of 30 joints on two soles; from the fifth on poses of single links.

An exponent is the slope of log(median) over log(size), by least squares; that of the contacts
leaves out free fall. A part of the tick grows with nothing, and products and factorisations with
the square and the cube of the joints, so that the exponent itself grows: the one of the last
three points is given, too.

    python benchmarks/scaling.py --plot scaling.png --json scaling.json
    python benchmarks/scaling.py --formulation reduced    # assembly in numpy
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import gc
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from shared import synthetic

import wbc
from wbc.command import Status

DT = 0.002
SWAY = 0.02  # m, of the centre of mass
FREQUENCY = 1.5  # Hz
MIDDLE = 30  # joints of the robot whose contacts and tasks are varied
JOINTS = (20, 25, 30, 40, 50, 60, 80, 100)
TASKS = (1, 2, 3, 4, 6, 8, 12, 16)
LINKS = ("left_hand", "right_hand", "head", "left_knee_link", "right_knee_link")
LINKS += ("left_elbow_link", "right_elbow_link", "pelvis", "left_hip_pitch_link")
LINKS += ("right_hip_pitch_link", "neck_1", "left_shoulder_yaw_link")

Make = Callable[[], wbc.WholeBodyController]


@dataclass
class Point:
    """One measurement.

    Attributes:
        size: joints, contacts or tasks.
        unknowns: of the QP.
        rows: of the QP, simple bounds included.
        task_rows: of all tasks.
        p50_us: median over the ticks, CPU time.
        p99_us: 99th percentile.
    """

    size: int
    unknowns: int
    rows: int
    task_rows: int
    p50_us: float
    p99_us: float


def contacts_of(robot: wbc.Robot, count: int) -> list[wbc.Contact]:
    """Return the first `count` contacts of: left sole, right sole, left hand, right hand."""
    soles = [wbc.SurfaceContact.from_sole(sole) for sole in robot.soles]
    hands = [wbc.SurfaceContact(f"{side}_hand", 0.015, 0.04) for side in ("left", "right")]
    return [*soles, *hands][:count]


def tasks_of(robot: wbc.Robot, count: int) -> list[wbc.Task]:
    """Return the first `count` tasks; the centre of mass comes first."""
    tasks: list[wbc.Task] = [
        wbc.ComTask(weight=1000.0),
        wbc.PostureTask(robot, weight=0.3),
        wbc.OrientationTask(robot.torso, weight=20.0),
        wbc.AngularMomentumTask(weight=0.01),
        *(wbc.FrameTask(link, weight=0.5) for link in LINKS),
    ]
    return tasks[:count]


def controller(
    robot: wbc.Robot, contacts: int, tasks: int, options: dict[str, Any]
) -> wbc.WholeBodyController:
    """Return a controller with the given contacts and tasks."""
    made = wbc.WholeBodyController(robot, DT, **options)
    for task in tasks_of(robot, tasks):
        made.add(task)
    made.set_contacts(contacts_of(robot, contacts))
    return made


def sway(control: wbc.WholeBodyController, start: np.ndarray, tick: int) -> None:
    """Set the CoM reference of a tick."""
    w = 2.0 * np.pi * FREQUENCY
    com = control.tasks[0]
    assert isinstance(com, wbc.ComTask)
    com.target = start + np.array([0.0, SWAY * np.sin(w * DT * tick), 0.0])
    com.velocity = np.array([0.0, SWAY * w * np.cos(w * DT * tick), 0.0])


def record(make: Make, ticks: int) -> list[wbc.State]:
    """Return the states of a sway, integrated from the controller's accelerations."""
    control = make()
    robot = control.robot
    state = robot.standing()
    start = wbc.Kinematics(robot, state).p_com
    states = []
    for tick in range(ticks):
        sway(control, start, tick)
        states.append(state)
        command = control.step(state)
        if command.status is not Status.OK:
            raise SystemExit(f"{robot.name}, tick {tick}: {command.explanation}")
        v = state.v + DT * command.acceleration
        state = wbc.State(pin.integrate(robot.model, state.q, DT * v), v)
    return states


def replay(make: Make, states: Sequence[wbc.State]) -> np.ndarray:
    """Return the CPU time of each tick, µs, shape (ticks,)."""
    control = make()
    start = wbc.Kinematics(control.robot, states[0]).p_com
    control.step(states[0])  # one-time initialisation
    times = np.empty(len(states))
    clock = time.thread_time_ns
    gc.collect()
    gc.disable()
    for tick, state in enumerate(states):
        sway(control, start, tick)
        begun = clock()
        control.step(state)
        times[tick] = 1e-3 * (clock() - begun)
    gc.enable()
    return times


def measure(make: Make, size: int, ticks: int, repeat: int) -> Point:
    """Record and replay, and use the minimum over the replays of each tick."""
    states = record(make, ticks)
    times = np.min([replay(make, states) for _ in range(repeat)], axis=0)
    control = make()
    control.step(states[0])
    problem = control.problem
    assert problem is not None
    task_rows = sum(task.size for task in control.tasks)
    p50, p99 = float(np.median(times)), float(np.percentile(times, 99))
    return Point(size, problem.C.shape[1], problem.lb.size, task_rows, p50, p99)


def exponent(points: Sequence[Point]) -> float:
    """Return the slope of log(median) over log(size)."""
    used = [p for p in points if p.size > 0]
    x, y = (np.log([getattr(p, name) for p in used]) for name in ("size", "p50_us"))
    return float(np.polyfit(x, y, 1)[0])


def per_unit(points: Sequence[Point]) -> float:
    """Return the additional time per joint, contact or task, µs, by least squares."""
    return float(np.polyfit([p.size for p in points], [p.p50_us for p in points], 1)[0])


def sweeps(ticks: int, repeat: int, options: dict[str, Any]) -> dict[str, list[Point]]:
    """Run the three sweeps; return their points by name."""
    found: dict[str, list[Point]] = {"joints": [], "contacts": [], "tasks": []}
    middle = synthetic.load(MIDDLE)
    for joints in JOINTS:
        robot = synthetic.load(joints)
        make = lambda robot=robot: controller(robot, 2, 4, options)  # noqa: E731
        found["joints"].append(measure(make, joints, ticks, repeat))
    for contacts in range(5):
        make = lambda contacts=contacts: controller(middle, contacts, 4, options)  # noqa: E731
        found["contacts"].append(measure(make, contacts, ticks, repeat))
    for tasks in TASKS:
        make = lambda tasks=tasks: controller(middle, 2, tasks, options)  # noqa: E731
        found["tasks"].append(measure(make, tasks, ticks, repeat))
    return found


def plot(found: dict[str, list[Point]], path: Path) -> None:
    """Plot medians, 99th percentiles and fits, one panel per sweep."""
    try:
        import matplotlib
    except ImportError as error:
        raise SystemExit("--plot needs matplotlib: pip install 'wbc[plots]'") from error
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import ScalarFormatter

    figure, axes = pyplot.subplots(1, 3, figsize=(12.0, 3.8), layout="constrained")
    for ax, (what, points) in zip(axes, found.items(), strict=True):
        size = np.array([p.size for p in points])
        median, high = (np.array([getattr(p, n) for p in points]) for n in ("p50_us", "p99_us"))
        ax.fill_between(size, median, high, alpha=0.2, label="to the 99th percentile", lw=0)
        ax.plot(size, median, "o-", label="median")
        ax.set_xlabel({"contacts": "surfaces in contact"}.get(what, what))
        text = f"exponent {exponent(points):.2f}, of the last three {exponent(points[-3:]):.2f}"
        ax.set_title(f"{text}; {per_unit(points):.1f} µs each", fontsize=9)
        ax.grid(alpha=0.3, which="both")
        if what == "joints":
            ax.set(xscale="log", yscale="log")
            slope, shift = np.polyfit(np.log(size), np.log(median), 1)
            ax.plot(size, np.exp(shift) * size**slope, "k:", lw=1, label="fit")
            for axis in (ax.xaxis, ax.yaxis):
                axis.set_major_formatter(ScalarFormatter())
                axis.set_minor_formatter(ScalarFormatter())
            ax.xaxis.set_ticks([20, 30, 40, 60, 80, 100])
            ax.xaxis.set_ticks([], minor=True)
        else:
            ax.set_ylim(bottom=0.0)
            ax.xaxis.get_major_locator().set_params(integer=True)
    axes[0].set_ylabel("tick, µs of CPU time")
    axes[0].legend(fontsize=8)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Run the sweeps, print the tables, and write the JSON file and the plot."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--ticks", type=int, default=150, help="recorded (default: %(default)s)")
    parser.add_argument("--repeat", type=int, default=7, help="replays (default: %(default)s)")
    parser.add_argument("--solver", help="the default one if left out")
    names = [f.value for f in wbc.Formulation]
    parser.add_argument("--formulation", choices=names, help="the default one if left out")
    parser.add_argument("--plot", type=Path, help="write the plot to this file (needs matplotlib)")
    parser.add_argument("--json", type=Path, help="write the tables to this file")
    args = parser.parse_args()
    options: dict[str, Any] = {"solver": args.solver} if args.solver else {}
    if args.formulation:
        options["formulation"] = wbc.Formulation(args.formulation)
    begun = time.perf_counter()
    found = sweeps(args.ticks, args.repeat, options)
    for what, points in found.items():
        print(f"{what:>9}{'unknowns':>10}{'rows':>7}{'task rows':>11}{'p50 µs':>9}{'p99 µs':>9}")
        for p in points:
            shape = f"{p.size:>9}{p.unknowns:>10}{p.rows:>7}{p.task_rows:>11}"
            print(shape + f"{p.p50_us:>9.1f}{p.p99_us:>9.1f}")
        end = exponent(points[-3:])
        print(f"exponent {exponent(points):.2f}, of the last three {end:.2f};", end=" ")
        print(f"{per_unit(points):.1f} µs more for each of the {what}\n")
    print(f"{time.perf_counter() - begun:.0f} s")
    if args.plot:
        plot(found, args.plot)
    if args.json:
        result = {
            what: {
                "exponent": exponent(points),
                "exponent_of_last_three": exponent(points[-3:]),
                "us_each": per_unit(points),
                "points": [asdict(p) for p in points],
            }
            for what, points in found.items()
        }
        args.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
