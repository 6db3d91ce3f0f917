"""A robot that ros2_control drives: states and commands over DDS, and the process that damps it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from rostools import MessageCollector, node

import wbc
from wbc.hardware import HardwareError, SafeHardware
from wbc.hardware.hardware import Reading
from wbc.hardware.ros2_control.connect import connect
from wbc.hardware.ros2_control.robot import Ros2ControlConfig, Ros2ControlRobot
from wbc.hardware.unitree.gantry import Gantry
from wbc.messages import message_type
from wbc.robot import Robot, load
from wbc.ros import Network, Node
from wbc.ros.stamp import stamp_from_seconds
from wbc.servo import ServoCommand, ServoGains
from wbc.sim import Mujoco

JOINT_STATE, IMU = message_type("sensor_msgs/msg/JointState"), message_type("sensor_msgs/msg/Imu")
TIMEOUT = 10.0  # s


class RobotSide:
    """Broadcasters and command controller of a robot.

    Its joint states have the joints in reverse, and one more.
    """

    def __init__(self, robot: Robot, domain: int) -> None:
        self.robot = robot
        self.node = node("robot", domain)
        self._names = [*reversed(robot.joint_names), "gripper"]
        self._joints = self.node.create_publisher(JOINT_STATE, "joint_states")
        self._imu = self.node.create_publisher(IMU, "imu_sensor_broadcaster/imu")
        self.commands = MessageCollector(
            self.node, "std_msgs/msg/Float64MultiArray", "effort_controller/commands"
        )

    def await_controller(self, processes: int = 1) -> None:
        publishers = (self._joints, self._imu)
        assert self.node.spin_until(
            lambda: all(p.get_subscription_count() >= processes for p in publishers), TIMEOUT
        )

    def publish(
        self, time: float, q: np.ndarray, v: np.ndarray, *, imu_time: float | None = None,
        missing: int = 0, tau: np.ndarray | None = None, gyro: Any = (0.0, 0.0, 0.0),
        force: Any = (0.0, 0.0, 9.81),
    ) -> None:  # fmt: skip
        extra = [0.0]
        values = {"position": q, "velocity": v, "effort": q * 0.0 if tau is None else tau}
        joints: Any = JOINT_STATE(
            name=self._names[missing:],
            **{key: [*x[::-1], *extra][missing:] for key, x in values.items()},
        )
        imu: Any = IMU()
        joints.header.stamp = stamp_from_seconds(time)
        imu.header.stamp = stamp_from_seconds(time if imu_time is None else imu_time)
        rates, acceleration = imu.angular_velocity, imu.linear_acceleration
        rates.x, rates.y, rates.z = gyro
        acceleration.x, acceleration.y, acceleration.z = force
        self._joints.publish(joints)
        self._imu.publish(imu)


@pytest.fixture(scope="module")
def g1() -> Robot:
    return load("g1")


@pytest.fixture
def robot_side(g1, domain) -> Iterator[RobotSide]:
    side = RobotSide(g1, domain)
    yield side
    side.node.close()


def test_states_come_in_the_order_of_the_model_and_efforts_go_in_that_of_the_controller(
    g1, robot_side, domain
) -> None:
    order = np.random.default_rng(0).permutation(g1.na)
    config = Ros2ControlConfig(joints=tuple(g1.joint_names[i] for i in order))
    hardware = Ros2ControlRobot(g1, node("wbc_hardware", domain), config)
    robot_side.await_controller()
    q, v, wanted, tau = np.random.default_rng(1).uniform(-0.3, 0.3, (4, g1.na))
    robot_side.publish(1.0, q, v, tau=tau, gyro=(0.1, 0.2, 0.3))
    reading = hardware.receive(TIMEOUT)
    assert reading is not None
    m = reading.measurement
    np.testing.assert_array_equal(m.joint_position, q)
    np.testing.assert_array_equal(m.joint_velocity, v)
    np.testing.assert_array_equal(m.joint_torque, tau)
    np.testing.assert_array_equal(m.gyro, (0.1, 0.2, 0.3))
    assert m.time == pytest.approx(1.0)
    assert reading.tilt == 0.0
    kp, kd = np.full(g1.na, 5.0), np.full(g1.na, 0.5)
    hardware.send(ServoCommand(wanted, 0.0 * v, tau, kp, kd))
    sent = robot_side.commands.find(lambda _: True)
    efforts = tau + 5.0 * (wanted - q) - 0.5 * v
    np.testing.assert_allclose(sent.data, efforts[order])
    hardware.close()


def test_servos_that_take_positions_get_those_that_exert_the_torque(g1, robot_side, domain) -> None:
    own = ServoGains(np.full(g1.na, 80.0), np.full(g1.na, 2.0))
    hardware = Ros2ControlRobot(g1, node("wbc_hardware", domain), Ros2ControlConfig(gains=own))
    robot_side.await_controller()
    q, v, wanted, tau = np.random.default_rng(1).uniform(-0.3, 0.3, (4, g1.na))
    robot_side.publish(1.0, q, v)
    assert hardware.receive(TIMEOUT) is not None
    command = ServoCommand(wanted, 0.0 * v, tau, np.full(g1.na, 5.0), np.full(g1.na, 0.5))
    hardware.send(command)
    sent = robot_side.commands.find(lambda _: True)
    exerted = own.kp * (sent.data - q) - own.kd * v
    np.testing.assert_allclose(exerted, command.torque(q, v))
    with pytest.raises(HardwareError, match="kp is 0"):
        Ros2ControlRobot(g1, hardware._node, Ros2ControlConfig(gains=ServoGains(0 * v, 0 * v)))
    with pytest.raises(HardwareError, match="'knee' differs"):
        Ros2ControlRobot(g1, hardware._node, Ros2ControlConfig(joints=("knee",)))
    hardware.close()


def test_states_without_an_imu_of_their_instant_are_no_reading_and_old_ones_are_dropped(
    g1, robot_side, domain
) -> None:
    hardware = Ros2ControlRobot(g1, node("wbc_hardware", domain))
    robot_side.await_controller()
    q = np.zeros(g1.na)
    robot_side.publish(1.0, q, q, imu_time=0.9)
    assert hardware.receive(0.2) is None
    robot_side.publish(2.0, q, q)
    assert hardware.receive(TIMEOUT) is not None
    robot_side.publish(1.5, q, q)
    assert hardware.receive(0.2) is None
    assert hardware.connection.reordered == 1
    robot_side.publish(3.0, q, q, missing=1)
    with pytest.raises(HardwareError, match=f"lack '{g1.joint_names[-1]}'"):
        hardware.receive(TIMEOUT)
    hardware.close()


def test_a_second_process_damps_the_joints_after_the_controller_has_gone(
    g1, robot_side, domain
) -> None:
    network = replace(Network(), domain_id=domain)
    hardware = connect(g1, network=network)
    robot_side.await_controller(processes=2)  # the one state that is published reaches both
    v = np.full(g1.na, 0.7)
    robot_side.publish(1.0, 0.0 * v, v)
    assert hardware.receive(TIMEOUT) is not None
    hardware.close()
    damping = ServoGains.for_robot(g1, 10.0).kd
    np.testing.assert_allclose(robot_side.commands.find(lambda m: m.data.any()).data, -damping * v)
    assert not robot_side.commands.find(lambda m: not m.data.any()).data.any()


class LockstepRobot(Ros2ControlRobot):
    """A simulated robot in a gantry, which advances when its next state is waited for."""

    def __init__(self, side: RobotSide, own_node: Node) -> None:
        super().__init__(side.robot, own_node)
        self.side = side
        self.plant = Mujoco(side.robot, foot_sensors=False)
        self.gantry = Gantry(side.robot)
        self.controlled = False
        side.await_controller()

    def now(self) -> float:
        return self.plant.time

    def receive(self, timeout: float) -> Reading | None:
        if timeout == 0.0:  # no state is waiting: it comes when it is waited for
            return None
        plant, zero = self.plant, np.zeros(self.robot.na)
        commands, sent = self.side.commands, self.connection.sent
        assert self.side.node.spin_until(lambda: len(commands) >= sent, TIMEOUT)
        tau = np.asarray(commands.last.data) if sent else zero
        # The gantry knows a held posture by its gains, and carried weight by its torques.
        gains = zero + float(plant.time > 0.5)
        self.gantry.apply(plant, ServoCommand(zero, zero, zero + self.controlled, gains, zero))
        plant.step(wbc.Command(tau, np.zeros(self.robot.nv), {}, zero, zero))
        m = plant.measure()
        self.side.publish(
            m.time, m.joint_position, m.joint_velocity, tau=m.joint_torque, gyro=m.gyro,
            force=m.accelerometer,
        )  # fmt: skip
        return super().receive(TIMEOUT)


@pytest.mark.slow
def test_a_robot_that_takes_efforts_starts_and_walks(g1, robot_side, domain) -> None:
    hardware = LockstepRobot(robot_side, node("wbc_hardware", domain))
    with SafeHardware(hardware, on_transition=lambda change: None) as plant:
        plant.start()
        hardware.controlled = True
        walker = wbc.Walker(g1)

        def command(time: float) -> None:
            walker.velocity = (0.3 if time > 1.5 else 0.0, 0.0, 0.0)

        report = wbc.run(walker, plant, 4.0, before_tick=command)
    assert report.survived, report.fell_why
    assert report.displacement_m[0] > 0.4
