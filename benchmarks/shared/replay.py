"""Records a walk once and replays its measurements without the physics.

Estimator and walker are deterministic: with the same measurements from the same start, each tick
repeats the computation of the simulation.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import wbc
from wbc.motions import MotionPlayer

Walking = wbc.Walker | MotionPlayer
MAX_DELAY = 10.0  # periods: after a longer interruption the loop does not catch up


class RecordingPlant:
    """A plant that records the measurements of another."""

    def __init__(self, plant: Any) -> None:
        self.plant, self.robot, self.dt = plant, plant.robot, plant.dt
        self.measurements: list[wbc.Measurement] = []

    @property
    def time(self) -> float:
        return float(self.plant.time)

    def measure(self) -> wbc.Measurement:
        self.measurements.append(self.plant.measure())
        return self.measurements[-1]

    def step(self, command: wbc.Command) -> None:
        self.plant.step(command)


class Replay:
    """A plant that replays measurements and records the times of `measure` and `step` calls."""

    def __init__(self, robot: wbc.Robot, dt: float, measurements: list[wbc.Measurement]) -> None:
        self.robot, self.dt, self._measurements = robot, dt, measurements
        self.measured_at, self.commanded_at = np.zeros((2, len(measurements)))
        self.ticks = 0

    @property
    def time(self) -> float:
        return self.ticks * self.dt

    def measure(self) -> wbc.Measurement:
        self.measured_at[self.ticks] = time.perf_counter()
        return self._measurements[self.ticks]

    def step(self, command: wbc.Command) -> None:
        self.commanded_at[self.ticks] = time.perf_counter()
        self.ticks += 1


class Idle:
    """Controller and estimator that do nothing."""

    def __init__(self, robot: wbc.Robot) -> None:
        self._estimate = wbc.Estimate(robot.standing())
        zero = np.zeros(robot.na)
        self._command = wbc.Command(zero, np.zeros(robot.nv), {}, zero, zero)

    def reset(self, state: wbc.State) -> None:
        """Return the same command every tick."""

    def update(self, measurement: wbc.Measurement, *, acceleration: object = None) -> wbc.Estimate:
        return self._estimate

    def step(self, estimate: wbc.Estimate) -> wbc.Command:
        return self._command


def walker(robot: wbc.Robot, dt: float, speed: float) -> wbc.Walker:
    """Return the walker that is recorded and replayed."""
    made = wbc.Walker(robot, dt=dt)
    made.velocity = (speed, 0.0, 0.0)
    return made


def record(
    robot: wbc.Robot,
    dt: float,
    speed: float,
    length: float,
    controller: Walking | None = None,
) -> list[wbc.Measurement]:
    """Return the measurements of a walk from standing, one per tick; by default of `walker`."""
    controller = controller or walker(robot, dt, speed)
    controller.velocity = (speed, 0.0, 0.0)
    with wbc.sim.Mujoco(robot, dt=dt) as plant:
        plant_recorder = RecordingPlant(plant)
        report = wbc.run(controller, plant_recorder, length)
    if not report.survived:
        raise SystemExit(f"{robot.name} fell at {report.fell_at_s} s: {report.fell_why}")
    return plant_recorder.measurements


def lateness(asked: np.ndarray, dt: float) -> np.ndarray:
    """Return (n,) the delay of each of n ticks behind a perfect schedule, s.

    The schedule restarts after an interruption of `MAX_DELAY` periods; each part of it is placed
    such that its most punctual tick is not late.
    """
    late = np.zeros_like(asked)
    due, begin = asked[0], 0
    for k, now in enumerate(asked):
        late[k] = now - due
        if late[k] >= MAX_DELAY * dt:
            late[begin : k + 1] -= late[begin : k + 1].min()
            due, begin = now, k + 1
        due += dt
    late[begin:] -= late[begin:].min(initial=np.inf) if begin < len(late) else 0.0
    return late
