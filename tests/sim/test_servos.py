"""Joint servos: gains, references, and the plant that models them."""

import copy
import pickle

import numpy as np
import pytest
from cases import slow
from simtools import robot

import wbc
from wbc.command import Command, Status
from wbc.errors import JointNotFound, PlantError, ServoError
from wbc.servo import ServoCommand, ServoGains
from wbc.servo_reference import ServoReference
from wbc.sim import JointServos, Mujoco


def make_command(na: int, *, acceleration: float = 0.0, status: Status = Status.OK) -> Command:
    return Command(
        np.zeros(na), np.full(na + 6, acceleration), {"sole": np.zeros(6)}, np.zeros(na),
        np.zeros(na), status,
    )  # fmt: skip


def test_gains_give_the_rotor_the_wanted_frequency_and_damping() -> None:
    talos = robot()
    gains = ServoGains.for_robot(talos, frequency=5.0, damping_ratio=0.5)
    rotor = talos.model.armature[6:]
    np.testing.assert_allclose(np.sqrt(gains.kp / rotor), 2.0 * np.pi * 5.0)
    np.testing.assert_allclose(gains.kd, np.sqrt(gains.kp * rotor))


def test_torque_controlled_joints_of_a_hybrid_have_no_gains() -> None:
    talos = robot()
    legs = [name for name in talos.joint_names if name.startswith("leg")]
    gains = ServoGains.for_robot(talos).with_torque_control(talos, legs)
    held = np.array([name not in legs for name in talos.joint_names])
    assert ((gains.kp > 0.0) == held).all()
    assert ((gains.kd > 0.0) == held).all()
    with pytest.raises(JointNotFound, match="leg_left_1_joint"):
        gains.with_torque_control(talos, ["leg_left_1"])


@pytest.mark.parametrize("kp", [[-1.0, 1.0], [np.nan, 1.0], [1.0]])
def test_invalid_gains_are_refused(kp: list[float]) -> None:
    with pytest.raises(ServoError):
        ServoGains(np.array(kp), np.ones(2))


def test_positions_alone_give_the_same_torque_as_the_whole_servo_command() -> None:
    random = np.random.default_rng(0)
    q, v, tau, measured_q, measured_v = random.standard_normal((5, 3))
    kp, kd = random.uniform(1.0, 2.0, (2, 3))
    command = ServoCommand(q, v, tau, kp, kd)
    torque = kp * (command.as_positions() - measured_q) - kd * measured_v
    np.testing.assert_allclose(torque, command.torque(measured_q, measured_v))
    with pytest.raises(ServoError, match="kp = 0"):
        ServoCommand(q, v, tau, 0.0 * kp, kd).as_positions()


def test_the_reference_integrates_the_acceleration_and_leaks_to_the_targets() -> None:
    gains, dt = ServoGains(np.ones(2), np.ones(2)), 0.002
    reference = ServoReference(gains, dt, position_leak=1e-9, velocity_leak=1e-9)
    reference.update(make_command(2))
    for _ in range(500):
        servo = reference.update(make_command(2, acceleration=3.0))
    np.testing.assert_allclose(servo.v, 3.0, rtol=1e-6)
    np.testing.assert_allclose(servo.q, 1.5, rtol=3e-3)
    leaking = ServoReference(gains, dt)
    leaking.update(make_command(2))
    for _ in range(500):
        servo = leaking.update(make_command(2, acceleration=3.0))
    np.testing.assert_allclose(servo.v, 3.0 * (1.0 - 10.0 * dt) / 10.0, rtol=0.05)


def test_the_reference_compensates_friction_in_the_direction_of_motion() -> None:
    gains, friction = ServoGains(np.ones(2), np.ones(2)), np.array([2.0, 0.0])
    reference = ServoReference(gains, 0.002, friction=friction)
    np.testing.assert_array_equal(reference.update(make_command(2)).tau, 0.0)
    for _ in range(500):
        servo = reference.update(make_command(2, acceleration=-9.0))
    np.testing.assert_allclose(servo.tau, [-2.0, 0.0], rtol=1e-3)
    with pytest.raises(ServoError, match="friction"):
        ServoReference(gains, 0.002, friction=np.ones(3))


def test_the_reference_starts_anew_when_a_tick_failed() -> None:
    reference = ServoReference(ServoGains(np.ones(2), np.ones(2)), 0.002)
    for _ in range(10):
        reference.update(make_command(2, acceleration=3.0))
    servo = reference.update(make_command(2, acceleration=3.0, status=Status.FAILED))
    assert not servo.q.any()
    assert not servo.v.any()


def test_a_motor_exerts_nothing_while_it_crosses_the_backlash() -> None:
    """The rotor of J kg·m² crosses half the play b after sqrt(b J / τ)."""
    simple = robot("simple_humanoid")
    gains = ServoGains(np.zeros(simple.na), np.zeros(simple.na))
    servos = JointServos(gains=gains, friction=0.0, backlash=0.02)
    plant = Mujoco(simple, timestep=0.0001, dt=0.002, servos=servos)
    tau = 10.0
    command = Command(
        np.full(simple.na, tau), np.zeros(simple.nv), {}, np.zeros(simple.na), np.zeros(simple.na)
    )
    crossing = np.sqrt(0.02 * simple.model.armature[6] / tau)
    while plant.time < crossing - plant.dt:
        plant.step(command)
        assert not plant.torque.any()
    plant.step(command)
    plant.step(command)
    np.testing.assert_allclose(plant.torque, np.minimum(tau, simple.tau_max))


def test_servo_properties_that_make_no_sense_are_refused() -> None:
    simple = robot("simple_humanoid")
    with pytest.raises(PlantError, match="friction"):
        JointServos(friction=-0.1)
    with pytest.raises(PlantError, match="2 joints"):
        Mujoco(simple, servos=JointServos(gains=ServoGains(np.ones(2), np.ones(2))))


@pytest.mark.parametrize("name", [slow("talos"), "g1"])
def test_joints_with_a_known_play_make_no_step_quick(name: str) -> None:
    robot = wbc.load(name)
    walker = wbc.Walker(robot, 0.002)
    plant = Mujoco(robot, dt=0.002, latency=0.002, seed=1, servos=JointServos())
    quick = []

    def command(time: float) -> None:
        walker.velocity = (0.3 if time > 0.5 else 0.0, 0.0, 0.0)
        quick.append(walker.gait_state.shortened or walker.gait_state.recovering)

    report = wbc.run(walker, plant, 3.5, before_tick=command)
    assert report.survived
    assert report.steps >= 2
    assert not any(quick)


def test_a_robot_with_servos_of_soft_gains_walks_and_its_plant_copies() -> None:
    simple = wbc.load("simple_humanoid")
    walker = wbc.Walker(simple, 0.004)
    walker.velocity = (0.3, 0.0, 0.0)
    plant = Mujoco(simple, dt=0.004, latency=0.002, servos=JointServos())
    report = wbc.run(walker, plant, 3.0)
    assert report.survived
    assert report.displacement_m[0] > 0.3
    copies = [copy.deepcopy(plant), pickle.loads(pickle.dumps(plant))]
    command = make_command(simple.na)
    for one in (plant, *copies):
        for _ in range(5):
            one.step(command)
    for one in copies:
        np.testing.assert_array_equal(one.data.qpos, plant.data.qpos)
