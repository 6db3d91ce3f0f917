"""Synthetic runs for tests of the log: ticks without physics, with random values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import wbc
from wbc.closeable import Closeable
from wbc.command import Command, Status
from wbc.estimation import Estimate
from wbc.log import FlightRecorder
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.runtime.stream import TickStream
from wbc.runtime.tick import Tick
from wbc.state import State
from wbc.telemetry import ContactPlan, Footstep, Telemetry


@dataclass
class Gains:
    stiffness: float = 3.5


@dataclass
class FakeController:
    """A controller with parameters and nothing else."""

    gains: Gains = field(default_factory=Gains)


@dataclass
class FakePlant:
    """A plant of which the log wants the period."""

    dt: float = 0.002
    seed: int = 7


class StreamedLog(Closeable):
    """A `FlightRecorder` with a stream that a test writes by hand.

    Args:
        path: of the log.
        robot: the robot.
        capacity: of the stream.
    """

    def __init__(self, path: str | Path, robot: Robot, capacity: int = 4096) -> None:
        self.log = FlightRecorder(path, robot)
        self.stream = TickStream(robot, capacity=capacity)
        self.log.attach(self.stream)
        self._index = 0

    def begin(self) -> None:
        self.log.begin(FakeController(), FakePlant())

    def record(self, tick: Tick) -> None:
        tick = replace(tick, index=self._index)
        self._index += 1
        self.stream.write(tick)
        self.log.observe(tick)

    def close(self) -> None:
        self.log.close()


def telemetry(rng: np.random.Generator, phase: str = "left") -> Telemetry:
    return Telemetry(
        com=rng.normal(size=3),
        dcm=rng.normal(size=3),
        dcm_reference=rng.normal(size=3),
        zmp=rng.normal(size=3),
        velocity=np.array([0.1, 0.2, 0.3]),
        heading=0.4,
        dcm_error=0.25,
        phase=phase,
        steps=3,
    )


def contact_plan(rng: np.random.Generator) -> ContactPlan:
    return ContactPlan(
        support=rng.normal(size=(5, 3)),
        footsteps=(
            Footstep("left", rng.normal(size=3), 0.3),
            Footstep("right", rng.normal(size=3), -0.4),
        ),
        swing_path=rng.normal(size=(4, 3)),
    )


def random_state(robot: Robot, rng: np.random.Generator) -> State:
    q = rng.normal(size=robot.nq)
    q[3:7] /= np.linalg.norm(q[3:7])
    return State(q, rng.normal(size=robot.nv))


def random_tick(
    robot: Robot,
    rng: np.random.Generator,
    time: float,
    *,
    status: Status = Status.OK,
    explanation: str = "",
    truth: bool = True,
    contacts: tuple[str, ...] = ("left_sole",),
) -> Tick:
    na, nv = robot.na, robot.nv
    command = Command(
        tau=rng.normal(size=na),
        acceleration=rng.normal(size=nv),
        wrenches={name: rng.normal(size=6) for name in contacts},
        q_target=rng.normal(size=na),
        v_target=rng.normal(size=na),
        status=status,
        explanation=explanation,
    )
    measurement = Measurement(
        time=time,
        joint_position=rng.normal(size=na),
        joint_velocity=rng.normal(size=na),
        gyro=rng.normal(size=3),
        accelerometer=rng.normal(size=3),
        foot_wrenches={s.name: rng.normal((0, 0, 400, 0, 0, 0)) for s in robot.soles},
    )
    estimate = Estimate(random_state(robot, rng))
    true_state = random_state(robot, rng) if truth else None
    return Tick(time, measurement, estimate, command, true_state, 1e-5 + 1e-6 * time, 3e-4)


def robot() -> Robot:
    return wbc.load("simple_humanoid")
