"""A simulated G1 behind the safety layer: it starts, walks, and is damped at every fault."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hardwaretools import HardwareRun, changed_state, flipped_bit

import wbc
from wbc.cli.hardware_run import lateness_line
from wbc.hardware import HardwareError, SafetyLimits, SafetyState, UnitreeG1
from wbc.hardware.hardware import Hardware, Reading
from wbc.hardware.safety.command_filter import CommandFilter
from wbc.hardware.safety.state_stream import StateFault, StateStream
from wbc.hardware.unitree.lockstep import Disturbance, undisturbed
from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.motors import G1_JOINTS
from wbc.hardware.unitree.stand_in_server import serve
from wbc.measurement import Measurement
from wbc.robot import load
from wbc.runtime.event import SAFETY, RunEvent
from wbc.runtime.loop import StopRun
from wbc.runtime.report import Report
from wbc.runtime.statistics import RunStatistics
from wbc.servo import ServoCommand


@pytest.fixture(scope="module")
def hanging() -> HardwareRun:
    """A robot that hangs in its gantry; tests change copies of it."""
    return HardwareRun.make()


@pytest.fixture(scope="module")
def standing(hanging) -> HardwareRun:
    """A robot that stands under control; tests change copies of it."""
    run = copy.deepcopy(hanging)
    run.plant.start()
    joints = run.stand_in.plant.ground_truth().q[7:]
    np.testing.assert_allclose(joints, run.robot.q_nominal[7:], atol=0.2)
    assert run.run(1.2).survived
    return run


def test_it_goes_from_damping_over_the_posture_to_control_and_ends_in_damping(standing) -> None:
    run = copy.deepcopy(standing)
    run.hold(0.01)
    run.plant.close()
    states = [transition.state for transition in run.plant.transitions]
    assert states == [
        SafetyState.DAMPING,
        SafetyState.POSTURE,
        SafetyState.STANDING,
        SafetyState.CONTROL,
        SafetyState.DAMPING,
    ]
    run.transport.advance()
    assert run.stand_in.damping


@pytest.mark.parametrize("error", [None, RuntimeError])
def test_the_end_of_a_run_damps_the_joints_before_anything_else_is_done(
    standing, monkeypatch, error
) -> None:
    run, walker = copy.deepcopy(standing), wbc.Walker(standing.robot)
    damped_at_report: list[bool] = []
    report = RunStatistics.report

    def recorded(*arguments: Any) -> Report:
        run.transport.advance()
        damped_at_report.append(run.stand_in.damping)
        return report(*arguments)

    def fail(time: float) -> None:
        if error is not None:
            raise error

    monkeypatch.setattr(RunStatistics, "report", recorded)
    if error is None:
        assert wbc.run(walker, run.plant, 0.004).survived
        assert damped_at_report == [True]
    else:
        with pytest.raises(error):
            wbc.run(walker, run.plant, 0.004, before_tick=fail)
        run.transport.advance()
        assert run.stand_in.damping
    assert run.plant.transitions[-1].reason == "the run is over"
    with pytest.raises(StopRun, match="connect to the robot anew"):
        run.measure()


def test_the_delays_of_commands_are_reported_as_those_of_a_simulation_are() -> None:
    late = np.full(1000, 0.0002)
    late[::50], late[7] = 0.0021, 0.009
    assert lateness_line(late, 0.002) == (
        "commands behind the robot's clock by 0.20 / 2.10 / 9.00 ms (median / 99 % / max), "
        "21 of 1000 by more than a period"
    )
    assert lateness_line(late[:0], 0.002) == "no command was sent"


def test_transitions_are_events_of_the_run(standing) -> None:
    class Events:
        def __init__(self) -> None:
            self.all: list[RunEvent] = []

        def begin(self, controller: object, plant: object) -> None: ...

        def observe(self, tick: object) -> None: ...

        def end(self, report: object) -> None: ...

        def on_event(self, event: RunEvent) -> None:
            self.all.append(event)

    run, events = copy.deepcopy(standing), Events()
    begin = run.plant.time

    def cut_the_wire(time: float) -> None:
        if time > begin + 0.01:
            run.transport.on_state = lambda _, data: []

    walker = wbc.Walker(standing.robot)
    report = wbc.run(walker, run.plant, 0.1, observers=[events], before_tick=cut_the_wire)
    assert not report.survived
    (event,) = events.all
    assert (event.kind, event.name) == (SAFETY, "damping")
    assert event.reason.startswith("no valid state message for 20 ms")
    assert begin + 0.005 < event.time < begin + 0.035


def test_it_walks_with_10_ms_of_latency_and_5_percent_of_the_messages_lost(standing) -> None:
    random = np.random.default_rng(0)

    def lossy(now: float, data: bytes) -> list[bytes]:
        return [] if random.random() < 0.05 else [data]

    run = copy.deepcopy(standing)
    run.transport.on_state = run.transport.on_command = lossy
    run.stand_in.plant._servos._latency = 8
    report = run.run(2.5, speed=0.35)
    assert report.survived
    assert report.displacement_m[0] > 0.3
    assert run.plant.lost > 20
    assert run.plant.latency.seconds == pytest.approx(0.010)


def frozen() -> Callable[[bytes], list[bytes]]:
    last: list[np.ndarray] = []

    def freeze(fields: np.ndarray) -> None:
        last[:] = last or [fields["imu_state"].copy()]
        fields["imu_state"] = last[0]

    return lambda data: [changed_state(data, freeze)]


def replaced(**fields: float) -> Callable[[bytes], list[bytes]]:
    def change(state: np.ndarray) -> None:
        for name, value in fields.items():
            state["motor_state"][name][0, 3] = value

    return lambda data: [changed_state(data, change)]


def tilted(data: bytes) -> list[bytes]:
    def change(state: np.ndarray) -> None:
        state["imu_state"]["quaternion"][0] = (np.cos(0.5), np.sin(0.5), 0.0, 0.0)

    return [changed_state(data, change)]


def key_pressed(data: bytes) -> list[bytes]:
    def change(state: np.ndarray) -> None:
        state["wireless_remote"][0, 3] = 0b10

    return [changed_state(data, change)]


FAULTS = {
    "a frozen IMU": (frozen(), "have not changed for", 0.0101),
    "NaN": (replaced(q=np.nan), "'left_knee_joint' is nan", 0.0),
    "an encoder jump": (replaced(q=1.2), "'left_knee_joint' jumped by", 0.0),
    "a joint that runs away": (replaced(dq=40.0), "'left_knee_joint' moves at", 0.0),
    "a fall": (tilted, "the base is tilted by 1.00 rad", 0.0),
    "the stop key": (key_pressed, "stop key", 0.0),
    "a lost wire": (lambda data: [], "no valid state message for 20 ms", 0.0201),
    "flipped bits": (lambda data: [flipped_bit(data)], "no valid state message", 0.0201),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_damps_the_joints_at_once_and_for_good(name: str, standing) -> None:
    disturb, reason, detection = FAULTS[name]
    run = copy.deepcopy(standing)
    begin = run.transport.now()
    run.transport.on_state = lambda _, data: disturb(data)
    with pytest.raises(StopRun, match=re.escape(reason)):
        run.hold(0.1)
    assert reason in run.plant.fault
    # Detected as soon as it can be, and damped in the same period.
    assert run.transport.now() - begin <= detection + 0.0021
    run.transport.advance()
    assert run.stand_in.damping
    with pytest.raises(StopRun):
        run.measure()
    with pytest.raises(StopRun):
        run.step(run.command)
    run.transport.advance()
    assert run.stand_in.damping


def test_reordered_messages_and_single_flipped_bits_are_dropped_and_counted(standing) -> None:
    held: list[bytes] = []
    count = iter(range(1_000_000))

    def reorder(now: float, data: bytes) -> list[bytes]:
        kind = next(count) % 10
        if kind == 0:
            held.append(data)
            return []
        return {1: [data, *held[-1:]], 2: [flipped_bit(data)]}.get(kind, [data])

    run = copy.deepcopy(standing)
    run.transport.on_state, run.transport.on_command = (
        reorder,
        lambda _, data: [flipped_bit(data), data],
    )
    run.hold(0.06)
    assert not run.plant.fault
    assert run.plant.connection.reordered >= 2
    assert run.plant.connection.corrupt >= 2
    assert run.stand_in.corrupt >= 20


def test_a_pause_of_the_controller_ends_the_run_and_the_robot_damps_meanwhile(standing) -> None:
    run = copy.deepcopy(standing)
    run.hold(0.01)
    for _ in range(12):
        run.transport.advance()
    assert run.stand_in.damping
    with pytest.raises(StopRun, match="ms behind the robot's clock"):
        run.hold(0.01)


def test_the_robot_damps_by_itself_when_its_controller_is_gone(standing) -> None:
    run = copy.deepcopy(standing)
    begin = run.transport.now()
    while not run.stand_in.damped:
        run.transport.advance()
    assert run.transport.now() - begin < 0.025


@pytest.mark.parametrize("lost", [True, False], ids=["lost wire", "motors off"])
def test_commands_that_the_robot_does_not_answer_end_the_run(lost: bool, standing) -> None:
    run = copy.deepcopy(standing)
    run.hold(0.04)  # the torques of these commands are known

    def off(_: float, data: bytes) -> list[bytes]:
        buffer = MessageBuffer(LOW_COMMAND)
        assert buffer.decode(data)
        buffer.fields["motor_cmd"]["mode"] = 0
        return [] if lost else [buffer.encode()]

    begin, run.transport.on_command = run.transport.now(), off
    with pytest.raises(StopRun, match="commands do not arrive"):
        run.hold(0.1)
    own = 0.02 if lost else 0.0  # s, until the robot damps its joints
    assert own < run.transport.now() - begin < own + 0.025


def test_a_robot_that_floods_holds_neither_the_start_nor_a_tick(hanging) -> None:
    flooding = FloodingRobot(copy.deepcopy(hanging).plant._hardware)
    states = StateStream(flooding, SafetyLimits())
    assert states.start(1.0)
    states.next()
    flooding.repeats = True
    with pytest.raises(StateFault, match="no valid state message"):
        states.next()
    rubbish = FloodingTransport()
    assert UnitreeG1(hanging.robot, rubbish).receive(0.02) is None
    assert rubbish.time == pytest.approx(0.025, abs=0.001)


def test_a_push_of_the_robot_counts_from_when_its_gantry_lets_go(hanging, standing) -> None:
    for run, pushed in ((copy.deepcopy(hanging), False), (copy.deepcopy(standing), True)):
        run.stand_in.schedule_push(0.002, (0.0, 1.0, 0.0))
        run.transport.advance()
        run.transport.advance()
        assert bool(run.stand_in.plant.push_force.any()) == pushed


def test_another_robot_is_refused(hanging) -> None:
    def other(now: float, data: bytes) -> list[bytes]:
        def change(state: np.ndarray) -> None:
            state["mode_machine"] = 4

        return [changed_state(data, change)]

    run = copy.deepcopy(hanging)
    run.transport.on_state = other
    with pytest.raises(HardwareError, match="mode_machine 4"):
        run.plant.start()
    with pytest.raises(HardwareError, match="not the joints of a G1"):
        UnitreeG1(load("simple_humanoid"), run.transport)


def exchanged(order: list[int]) -> tuple[Disturbance, Disturbance]:
    """Motors in another order in the states, and in the commands."""

    def states(state: np.ndarray) -> None:
        state["motor_state"][0, order] = state["motor_state"][0, :29].copy()

    def swap(now: float, data: bytes) -> list[bytes]:
        buffer = MessageBuffer(LOW_COMMAND)
        assert buffer.decode(data)
        buffer.fields["motor_cmd"][0, :29] = buffer.fields["motor_cmd"][0, order]
        return [buffer.encode()]

    return lambda now, data: [changed_state(data, states)], swap


SHIFTED = [*range(19, 29), *range(19)]
SIDES = [*range(6, 12), *range(6), 12, 13, 14, *range(22, 29), *range(15, 22)]


@pytest.mark.parametrize("in_both", [False, True], ids=["in the commands", "in both"])
@pytest.mark.parametrize("order", [SHIFTED, SIDES], ids=["shifted", "sides exchanged"])
def test_motors_in_another_order_are_found_before_the_controller_takes_over(
    order: list[int], in_both: bool, hanging
) -> None:
    run = copy.deepcopy(hanging)
    on_state, run.transport.on_command = exchanged(order)
    if in_both:
        run.transport.on_state = on_state
    with pytest.raises(HardwareError, match=r"another order|moves at|jumped|outside"):
        run.plant.start()
    assert run.plant.state is SafetyState.DAMPING


def test_it_does_not_start_from_a_posture_far_away_or_without_a_robot(hanging) -> None:
    def bent(now: float, data: bytes) -> list[bytes]:
        def change(state: np.ndarray) -> None:
            state["motor_state"]["q"][0, 3] = 2.5

        return [changed_state(data, change)]

    for disturb, reason in (
        (bent, "'left_knee_joint' is .* from the nominal posture"),
        (lambda now, data: [], "check the cable"),
    ):
        run = copy.deepcopy(hanging)
        run.transport.on_state = disturb
        with pytest.raises(HardwareError, match=reason):
            run.plant.start()


def test_what_came_before_the_start_is_no_loss(hanging) -> None:
    run = copy.deepcopy(hanging)
    for on_state in (undisturbed, lambda now, data: [], undisturbed):
        run.transport.on_state = on_state
        for _ in range(20):
            run.transport.advance()
    run.plant._limits = SafetyLimits(start_distance=1e-3)  # it ends the start early
    with pytest.raises(HardwareError, match="from the nominal posture"):
        run.plant.start()
    assert run.plant.lost == 0


def test_a_command_before_the_start_and_one_that_is_not_finite_are_refused(
    hanging, standing
) -> None:
    with pytest.raises(StopRun, match="before the robot was started"):
        copy.deepcopy(hanging).step(standing.command)
    run = copy.deepcopy(standing)
    run.measure()
    with pytest.raises(StopRun, match="not finite"):
        run.step(replace(run.command, tau=np.full(run.robot.na, np.nan)))


def test_commands_beyond_the_limits_are_brought_within_them() -> None:
    robot = load("g1")
    rise = CommandFilter(robot, SafetyLimits(), 0.002)
    still = np.zeros(robot.na)
    m = Measurement(0.0, robot.q_nominal[7:], still, still[:3], still[:3])
    far = ServoCommand(still + 9.0, still + 900.0, still + 1e4, still + 100.0, still + 1.0)
    for _ in range(10):
        got = rise.apply(far, m)
        assert (np.abs(got.tau) <= robot.tau_max).all()
    np.testing.assert_array_equal(got.q, robot.q_max)
    np.testing.assert_array_equal(got.v, robot.v_max)
    rise.reset()
    first = rise.apply(replace(far, kp=still, kd=still), m)
    np.testing.assert_allclose(first.tau, 0.2 * robot.tau_max)  # 2 ms of 10


def test_the_joints_of_the_motors_are_those_of_the_model() -> None:
    assert len(set(G1_JOINTS)) == 29
    assert set(G1_JOINTS) == set(load("g1").joint_names)


class FloodingRobot:
    """A robot whose next reading always waits.

    Attributes:
        repeats: whether they are all of the same instant.
    """

    def __init__(self, hardware: Hardware) -> None:
        self._hardware, self.robot, self.period = hardware, hardware.robot, hardware.period
        self._last, self._passed = hardware.receive(1.0), 0.0
        self.repeats = False

    def now(self) -> float:
        return self._hardware.now() + self._passed

    def receive(self, timeout: float) -> Reading | None:
        self._passed += 1e-5
        if not self.repeats:
            self._last = self._hardware.receive(1.0)
        return self._last


class FloodingTransport:
    """A wire on which rubbish waits without end."""

    time = 0.0

    def now(self) -> float:
        return self.time

    def receive(self, timeout: float) -> bytes:
        self.time += 1e-4
        return b"rubbish"


class NobodyConnected:
    """A wire at whose other end nobody is."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def now(self) -> float:
        return 0.0

    def receive(self, timeout: float) -> None:
        return None

    def send(self, data: bytes) -> None:
        self.sent.append(data)

    def close(self) -> None:
        pass


def test_the_stand_in_sends_states_until_it_is_stopped_and_is_damped_meanwhile(hanging) -> None:
    run, transport = copy.deepcopy(hanging), NobodyConnected()
    serve(run.stand_in, transport, math.inf, stop=lambda: len(transport.sent) == 5)
    buffer = MessageBuffer(LOW_STATE)
    assert all(buffer.decode(data) for data in transport.sent)
    assert buffer.fields["tick"][0] == 10
    assert run.stand_in.damping
