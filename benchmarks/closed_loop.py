"""The real-time factor of a closed loop on one core, and the time of each of its parts.

A robot walks in MuJoCo: physics at 1 kHz, noisy sensors, state estimator, walker and controller
at 500 Hz, without observers. The factor of real time is simulated time over the CPU time of the
whole process during `wbc.run`. In a second walk each part of a control period is timed, and its
torques are then applied to MuJoCo alone, for comparison. "Measurement to command" is the time of
estimator and walker, including the controller; its ratio to the controller alone shows the cost of
everything around the quadratic program. All rounds repeat the same walk; the table uses the minimum
of each time over the rounds, because other load on the machine can only add time. The ratio is the
median over all periods of all rounds, each by its own times: whatever slows the machine for a while
slows both, whereas minima from different rounds do not add up.

    python benchmarks/closed_loop.py
    python benchmarks/closed_loop.py --robot talos --rounds 5 --json out/closed_loop.json
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import wbc
from wbc.estimation import Estimator
from wbc.kinematics import Kinematics
from wbc.sim import Mujoco

SPEEDS = {"talos": 0.3, "g1": 0.25, "simple_humanoid": 0.3}
SETTLE = 0.5  # s of standing before the first step

#: The parts of a control period; the last is `wbc.run` itself, including its statistics.
STAGES = ("plant", "estimator", "gait and balance", "controller", "loop")
#: Sums of stages, and a comparison.
TOTALS = ("measurement to command", "period", "mj_step alone")
_PARTS = ("plant", "estimator", "walker", "controller", "period")


class Stopwatch:
    """Accumulates the time of the wrapped methods in each control period.

    Attributes:
        periods: One list of times, s, for each of `_PARTS`.
    """

    def __init__(self) -> None:
        self.periods: list[list[float]] = []
        self._begun: float | None = None
        self._spent = dict.fromkeys(_PARTS, 0.0)

    def around(self, method: Callable[..., Any], part: str) -> Callable[..., Any]:
        """Return the method with its time added to `part`."""
        spent, clock = self._spent, time.perf_counter

        def timed(*args: Any, **options: Any) -> Any:
            start = clock()
            try:
                return method(*args, **options)
            finally:
                spent[part] += clock() - start

        return timed

    def stop(self) -> None:
        """End a control period."""
        if self._begun is not None:
            self._spent["period"] = time.perf_counter() - self._begun
            self.periods.append(list(self._spent.values()))

    def start(self) -> None:
        """Begin a control period."""
        for part in _PARTS:
            self._spent[part] = 0.0
        self._begun = time.perf_counter()


class Timed:
    """A wrapper of a plant, an estimator or a controller that times some of its methods."""

    def __init__(self, inner: Any, watch: Stopwatch, part: str, methods: tuple[str, ...]) -> None:
        self._inner = inner
        for name in methods:
            setattr(self, name, watch.around(getattr(inner, name), part))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


def steer(walker: wbc.Walker, speed: float) -> Callable[[float], None]:
    """Stand for a moment, then walk."""

    def command(at: float) -> None:
        wanted = (speed if at >= SETTLE else 0.0, 0.0, 0.0)
        if walker.velocity != wanted:
            walker.velocity = wanted

    return command


def cpu_time(robot: wbc.Robot, speed: float, duration: float) -> float:
    """Return the CPU time of the process per simulated time, s/s."""
    walker = wbc.Walker(robot)
    with Mujoco(robot) as plant:
        start = time.process_time()
        report = wbc.run(walker, plant, duration, before_tick=steer(walker, speed))
        spent = time.process_time() - start
    if not report.survived:
        raise SystemExit(f"{robot.name} fell at {report.fell_at_s:.2f} s: {report.fell_why}")
    return spent / duration


def stage_times(robot: wbc.Robot, speed: float, duration: float) -> dict[str, np.ndarray]:
    """Return the time of each stage in each period, µs, shape (periods,)."""
    walker, watch = wbc.Walker(robot), Stopwatch()
    torques: list[np.ndarray] = []
    walker.controller.solve = watch.around(walker.controller.solve, "controller")
    update = Kinematics.update
    Kinematics.update = watch.around(update, "controller")
    with Mujoco(robot) as plant:
        timed_plant = Timed(plant, watch, "plant", ("measure", "step", "ground_truth"))
        estimator = Timed(Estimator(robot, plant.dt), watch, "estimator", ("update",))
        command = steer(walker, speed)

        def between(at: float) -> None:
            watch.stop()
            torques.append(plant.torque)
            command(at)
            watch.start()

        try:
            wbc.run(
                Timed(walker, watch, "walker", ("step",)),
                timed_plant,
                duration,
                estimator=estimator,
                before_tick=between,
            )
        finally:
            Kinematics.update = update
    parts = dict(zip(_PARTS, 1e6 * np.array(watch.periods).T, strict=True))
    stages = {name: parts[name] for name in ("plant", "estimator", "controller")}
    stages["gait and balance"] = parts["walker"] - parts["controller"]
    stages["loop"] = parts["period"] - parts["plant"] - parts["estimator"] - parts["walker"]
    stages["measurement to command"] = parts["estimator"] + parts["walker"]
    stages["period"] = parts["period"]
    stages["mj_step alone"] = bare_physics(robot, torques[1:])
    return stages


def bare_physics(robot: wbc.Robot, torques: list[np.ndarray]) -> np.ndarray:
    """Return the time of MuJoCo's steps under recorded torques, µs, shape (periods,)."""
    spent = []
    with Mujoco(robot) as plant:
        model, data, substeps = plant.model, plant.data, round(plant.dt / plant.timestep)
        for torque in torques:
            data.ctrl[:] = torque
            start = time.perf_counter()
            mujoco.mj_step(model, data, nstep=substeps)
            spent.append(time.perf_counter() - start)
    return 1e6 * np.array(spent)


def measure(name: str, duration: float, rounds: int) -> dict[str, float]:
    """Return median and mean of each stage over the periods, and the real-time factor."""
    robot = wbc.load(name)
    cpu_time(robot, 0.0, 0.1)  # compiles or reads what is needed on first use
    costs, runs = [], []
    for _ in range(rounds):
        costs.append(cpu_time(robot, SPEEDS[name], duration))
        runs.append(stage_times(robot, SPEEDS[name], duration))
    row: dict[str, float] = {}
    for stage in (*STAGES, *TOTALS):
        key, times = stage.replace(" ", "_"), np.min([run[stage] for run in runs], axis=0)
        row[f"{key}_p50_us"], row[f"{key}_mean_us"] = float(np.median(times)), float(times.mean())
    ratios = [run["measurement to command"] / run["controller"] for run in runs]
    row["command_over_controller"] = float(np.median(ratios))
    row["real_time_factor"] = 1.0 / min(costs)
    row["real_time_factor_worst"] = 1.0 / max(costs)
    return row


def main() -> None:
    """Walk, print the table, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", action="append", choices=sorted(SPEEDS), help="only this one")
    parser.add_argument("--duration", type=float, default=6.0, help="s of a walk")
    parser.add_argument("--rounds", type=int, default=5, help="(default: %(default)s)")
    parser.add_argument("--json", type=Path, help="write the table there")
    args = parser.parse_args()
    columns = (*STAGES, *TOTALS)
    print("µs per control period of 2 ms, median / mean; × controller: measurement to command over")
    print("the controller alone, median over the periods; × real time by CPU time")
    print(f"| robot | {' | '.join(columns)} | × controller | × real time |")
    print(f"| --- |{' --- |' * (len(columns) + 2)}")
    table = {}
    for name in args.robot or SPEEDS:
        row = table[name] = measure(name, args.duration, args.rounds)
        keys = [column.replace(" ", "_") for column in columns]
        cells = [f"{row[f'{k}_p50_us']:.0f} / {row[f'{k}_mean_us']:.0f}" for k in keys]
        cells += [f"{row['command_over_controller']:.2f}", f"{row['real_time_factor']:.1f}"]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
    if args.json:
        args.json.parent.mkdir(parents=True, exist_ok=True)
        args.json.write_text(json.dumps(table, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
