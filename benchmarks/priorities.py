"""Measures what strict priorities cost: a tick with several levels against a weighted one.

`walk`: a short walk in MuJoCo is recorded and replayed as in `benchmarks/tick.py`, once with the
walker's weights and once with the same tasks on three levels: stance foot, swing foot and centre of
mass, then the trunk, then posture and angular momentum. `stack`: a standing humanoid with four
levels, as in OpenSoT's humanoid example: centre of mass (the feet are contacts), hands, trunk,
posture, within the limits of joints and torques; the hands circle. The minimum over the replays is
used for each tick: other load on a shared machine can only add time.

    python benchmarks/priorities.py
    python benchmarks/priorities.py --robot g1 --json out/priorities.json
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import gc
import json
import time
from pathlib import Path

import numpy as np
import pinocchio as pin
from tick import Recorder, record

import wbc
from wbc.robot.upper_body import UpperBody


def set_levels(controller: wbc.WholeBodyController, levels: bool) -> None:
    """Give every task of a walker its level, or all of them the first."""
    for task in controller.tasks:
        priority = 1
        if levels and isinstance(task, wbc.OrientationTask):
            priority = 2
        elif levels and isinstance(task, wbc.PostureTask | wbc.AngularMomentumTask):
            priority = 3
        task.priority = priority


class TimedController:
    """Takes the place of a walker's `controller.solve` and times whole ticks with some levels."""

    def __init__(self, controller: wbc.WholeBodyController, levels: bool) -> None:
        self.controller, self.levels = controller, levels
        self.solve = controller.solve
        self.times: list[float] = []
        self.failures = 0

    def __call__(self, kin: wbc.Kinematics) -> wbc.Command:
        set_levels(self.controller, self.levels)
        start = time.perf_counter()
        kin.update(kin.state)
        command = self.solve(kin)
        self.times.append(1e6 * (time.perf_counter() - start))
        self.failures += command.status is not wbc.Status.OK
        return command


def walk_ticks(robot: wbc.Robot, recorder: Recorder, speed: float, levels: bool) -> TimedController:
    """Return the ticks of a replayed walk."""
    walker = wbc.Walker(robot)
    walker.reset(recorder.start)
    walker.velocity = (speed, 0.0, 0.0)
    controller = walker.controller
    ticks = TimedController(controller, levels)
    controller.solve = ticks  # type: ignore[method-assign, assignment]
    for estimate in recorder.ticks:
        walker.step(estimate)
    return ticks


def stack_ticks(robot: wbc.Robot, ticks: int, levels: bool) -> TimedController:
    """Return the ticks of a standing robot with four levels whose hands circle for two seconds."""
    priorities = (1, 2, 3, 4) if levels else (1, 1, 1, 1)
    controller = wbc.WholeBodyController(robot)
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    controller.add(wbc.ComTask(weight=1000.0, priority=priorities[0]))
    state, dt = robot.standing(), controller.dt
    kin = wbc.Kinematics(robot, state)
    hands = []
    for arm in UpperBody.of(robot).arms:
        start = kin.frame(arm.hand).translation.copy()
        task = wbc.PositionTask(arm.hand, start, priority=priorities[1])
        hands.append((controller.add(task), start))
    controller.add(wbc.OrientationTask(robot.torso, priority=priorities[2]))
    controller.add(wbc.PostureTask(robot, priority=priorities[3]))
    measured = TimedController(controller, levels)
    for tick in range(ticks):
        angle = np.pi * tick * dt
        for task, start in hands:
            task.target = start + 0.05 * np.array([np.sin(angle), 0.0, 1.0 - np.cos(angle)])
        start_time = time.perf_counter()
        command = controller.step(state)
        measured.times.append(1e6 * (time.perf_counter() - start_time))
        measured.failures += command.status is not wbc.Status.OK
        v = state.v + dt * command.acceleration
        state = wbc.State(pin.integrate(robot.model, state.q, dt * v), v)
    return measured


def row_of(runs: list[TimedController]) -> dict[str, float]:
    """Return the figures of some replays of the same ticks, µs."""
    times = np.min([run.times for run in runs], axis=0)
    p50, p99 = np.percentile(times, (50, 99))
    failed = max(run.failures for run in runs)
    return {"p50_us": p50, "p99_us": p99, "ticks": times.size, "failed": failed}


def main() -> None:
    """Measure, print the table and write the JSON file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--speed", type=float, default=0.3, help="m/s (default: %(default)s)")
    parser.add_argument("--duration", type=float, default=2.0, help="s (default: %(default)s)")
    parser.add_argument("--repeat", type=int, default=5, help="replays (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="write the table to this file")
    args = parser.parse_args()
    robot = wbc.load(args.robot)
    recorder = record(robot, args.speed, args.duration)
    ticks, repeat = len(recorder.ticks), range(args.repeat)
    table: dict[str, dict[str, dict[str, float]]] = {}
    gc.disable()
    for levels in (False, True):
        kind = "levels" if levels else "weighted"
        walks = [walk_ticks(robot, recorder, args.speed, levels) for _ in repeat]
        stacks = [stack_ticks(robot, ticks, levels) for _ in repeat]
        table.setdefault("walk, 3 levels", {})[kind] = row_of(walks)
        table.setdefault("stack, 4 levels", {})[kind] = row_of(stacks)
    print(f"{robot.name}: tick in µs, p50 / p99")
    for name, rows in table.items():
        texts = [f"{k} {r['p50_us']:.0f} / {r['p99_us']:.0f}" for k, r in rows.items()]
        ratio = rows["levels"]["p50_us"] / rows["weighted"]["p50_us"]
        failed = sum(r["failed"] for r in rows.values())
        print(f"{name:<16} {'; '.join(texts)}; ratio {ratio:.2f}; {failed:.0f} ticks failed")
    if args.json:
        args.json.write_text(json.dumps({"robot": robot.name, **table}, indent=2) + "\n")


if __name__ == "__main__":
    main()
