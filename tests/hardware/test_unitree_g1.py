"""The driver of a G1: whose messages it takes, how it times them, and what its feet carry."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest
from hardwaretools import HardwareRun

from wbc.hardware import HardwareError, UnitreeG1, feet_carry
from wbc.hardware.period import measured_period
from wbc.hardware.unitree.messages import LOW_STATE, MessageBuffer
from wbc.hardware.unitree.motors import G1_MACHINES, SIMULATOR_MACHINE
from wbc.robot import load

WITH_SIMULATORS = (*G1_MACHINES, SIMULATOR_MACHINE)


class Wire:
    """A wire with given messages, each of which arrives 3 ms after the one before it."""

    def __init__(self, *messages: bytes) -> None:
        self.messages = deque(messages)
        self.time = 1000.0

    def now(self) -> float:
        return self.time

    def receive(self, timeout: float) -> bytes | None:
        self.time += 0.003
        return self.messages.popleft() if self.messages else None

    def send(self, data: bytes) -> None:
        pass

    def close(self) -> None:
        pass


def state_of(machine: int, tick: int, checksum: bool = True) -> bytes:
    buffer = MessageBuffer(LOW_STATE)
    buffer.fields["mode_machine"], buffer.fields["tick"] = machine, tick
    data = buffer.encode()
    return data if checksum else data[:-4] + bytes(4)


def test_a_simulator_without_clock_and_checksum_is_timed_by_the_arrival_of_its_messages() -> None:
    wire = Wire(*[state_of(SIMULATOR_MACHINE, 0, checksum=False)] * 60)
    robot = UnitreeG1(load("g1"), wire, machines=WITH_SIMULATORS)
    times = [robot.receive(1.0).measurement.time for _ in range(10)]
    np.testing.assert_allclose(np.diff(times), 0.003)
    assert measured_period(robot) == 0.003


def test_a_simulator_with_a_clock_is_timed_by_it() -> None:
    wire = Wire(*(state_of(SIMULATOR_MACHINE, tick) for tick in (0, 2, 4, 4, 8)))
    robot = UnitreeG1(load("g1"), wire, machines=WITH_SIMULATORS)
    times = [robot.receive(1.0).measurement.time for _ in range(4)]
    np.testing.assert_allclose(np.diff(times), (0.002, 0.002, 0.004))
    assert robot.connection.reordered == 1


def test_without_leave_simulators_are_refused_and_missing_checksums_are_wrong_ones() -> None:
    for machine, machines in ((SIMULATOR_MACHINE, G1_MACHINES), (5, WITH_SIMULATORS)):
        robot = UnitreeG1(load("g1"), Wire(state_of(machine, 0, checksum=False)), machines=machines)
        assert robot.receive(0.001) is None
        assert robot.connection.corrupt == 1
    with pytest.raises(HardwareError, match="simulator; connect over the interface 'lo'"):
        UnitreeG1(load("g1"), Wire(state_of(SIMULATOR_MACHINE, 2))).receive(1.0)


@pytest.mark.parametrize(("step", "period"), [(1, 0.002), (2, 0.002), (5, 0.005)])
def test_the_period_of_control_is_that_of_the_messages_but_at_least_2_ms(step, period) -> None:
    wire = Wire(*(state_of(5, step * i) for i in range(100)))
    assert measured_period(UnitreeG1(load("g1"), wire)) == period


def test_a_robot_that_falls_silent_has_no_period() -> None:
    with pytest.raises(HardwareError, match="check the cable"):
        measured_period(UnitreeG1(load("g1"), Wire(state_of(5, 2), state_of(5, 4))))


def test_the_posture_is_held_in_the_gantry_until_the_feet_carry_the_robot() -> None:
    run = HardwareRun.make()
    run.stand_in._gantry._held_since = run.stand_in.plant.time + 1.5  # it is lowered late
    loads: list[float] = []

    def ready(load: float | None) -> bool:
        assert load is not None
        loads.append(load)
        return feet_carry(load)

    run.plant._ready = ready
    run.plant.start()
    carrying = [feet_carry(load) for load in loads]
    assert not any(carrying[:-1])
    assert carrying[-1]
    assert run.stand_in.plant.ground_truth().q[2] == pytest.approx(run.robot.q_nominal[2], abs=0.02)
