"""A robot that `ros2_control` drives: joint and IMU states in, an array of commands out."""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import ConnectionState, Reading, tilt_of
from wbc.measurement import Measurement
from wbc.messages import message_type
from wbc.robot import Robot
from wbc.ros.node import Node
from wbc.ros.stamp import to_seconds
from wbc.servo import ServoCommand, ServoGains

_ARRAY = message_type("std_msgs/msg/Float64MultiArray")
_DAMPING_FREQUENCY = 10.0  # Hz, of the servos whose velocity gains damp joints of effort


class _JointStates(NamedTuple):
    """Time, s, positions, rad, velocities, rad/s, and torques, N·m, in the model's order."""

    time: float
    position: np.ndarray
    velocity: np.ndarray
    torque: np.ndarray | None


@dataclass(frozen=True)
class Ros2ControlConfig:
    """Names and properties of the controllers and broadcasters of a robot.

    Attributes:
        period: period of the joint states, s (`update_rate` of the controller manager).
        command_topic: topic of the commands, `/<name of the controller>/commands`.
        joints: the controller's parameter of that name, its order of the joints; None for the
            model's order.
        gains: gains of the robot's own servos if the joints take positions; None if they take
            efforts.
        state_topic: topic of the joint states.
        imu_topic: topic of the IMU, whose readings are in the axes of `robot.imu`.
    """

    period: float = 0.002
    command_topic: str = "/effort_controller/commands"
    joints: tuple[str, ...] | None = None
    gains: ServoGains | None = None
    state_topic: str = "/joint_states"
    imu_topic: str = "/imu_sensor_broadcaster/imu"


class Ros2ControlRobot:
    """A robot behind the controllers of `ros2_control`.

    The joint states come from its `joint_state_broadcaster` and the IMU from its
    `imu_sensor_broadcaster`, with equal stamps; joints that the model does not have are ignored.
    The commands go to a controller of the package `forward_command_controller` (or
    `effort_controllers`, `position_controllers`), which passes an array of numbers on to its
    joints. Efforts are those of the servo law at the last joint states,

        τ = tau + kp (q − q_measured) + kd (v − v_measured).

    Servos that take positions, of gains kp and kd, exert the same with

        q* = q_measured + (τ + kd v_measured) / kp.

    These controllers hold the last command when nobody sends any; `connect` therefore starts a
    process that damps the joints when this one has gone.

    Args:
        robot: its model.
        node: node of ROS 2, which this object closes.
        config: names and properties.

    Attributes:
        robot: its model.
        period: period of the joint states, s.
        connection: counters of the connection.

    Raises:
        HardwareError: the controller's joints are not those of the model, or a servo that takes
            positions has kp = 0.
    """

    def __init__(self, robot: Robot, node: Node, config: Ros2ControlConfig | None = None) -> None:
        config = config or Ros2ControlConfig()
        names, gains = list(robot.joint_names), config.gains
        order = names if config.joints is None else list(config.joints)
        if sorted(order) != sorted(names):
            differing = sorted(set(order) ^ set(names)) or ["a joint that is named twice"]
            raise HardwareError(
                f"the joints of the controller must be those of '{robot.name}', each once; "
                f"'{differing[0]}' differs"
            )
        if gains is not None and not (gains.kp > 0.0).all():
            joint = names[int(np.flatnonzero(gains.kp <= 0.0)[0])]
            raise HardwareError(
                f"the servo of '{joint}' takes positions, but its gain kp is 0: give the gains "
                "that the robot's servos have, or none for joints that take efforts"
            )
        self.robot, self.period = robot, config.period
        self.connection = ConnectionState()
        self._node, self._gains = node, gains
        self._order = np.array([names.index(name) for name in order])
        self._damping = (gains or ServoGains.for_robot(robot, _DAMPING_FREQUENCY)).kd
        self._tau_max = np.asarray(robot.tau_max)
        self._names: list[str] = []  # of the last joint states
        self._indices = np.zeros(0, dtype=int)  # of the model's joints in them
        self._joints: _JointStates | None = None
        self._imu: Any = None
        self._paired = -math.inf
        self._readings: deque[Reading] = deque()
        self._publisher = node.create_publisher(_ARRAY, config.command_topic)
        node.create_subscription("sensor_msgs/msg/JointState", config.state_topic, self._on_joints)
        node.create_subscription("sensor_msgs/msg/Imu", config.imu_topic, self._on_imu)

    def now(self) -> float:
        """Return the time of the performance counter, s."""
        return time.perf_counter()

    def receive(self, timeout: float) -> Reading | None:
        """Return the oldest reading that was not returned yet; None after `timeout` s.

        Raises:
            HardwareError: the joint states lack a joint of the model, or its velocity.
        """
        self._node.spin_until(lambda: self._readings, timeout)
        return self._readings.popleft() if self._readings else None

    def _on_joints(self, message: Any) -> None:
        if message.name != self._names:
            self._names, self._indices = list(message.name), self._find_joints(message.name)
        count = len(self._names)
        if message.position.size != count or message.velocity.size != count:
            raise HardwareError(
                f"the joint states have {message.position.size} positions and "
                f"{message.velocity.size} velocities of {count} joints: the robot has to state "
                "both for every joint"
            )
        at, effort = self._indices, message.effort
        self._joints = _JointStates(
            to_seconds(message.header.stamp),
            message.position[at],
            message.velocity[at],
            effort[at] if effort.size == count else None,
        )
        self._pair()

    def _find_joints(self, names: list[str]) -> np.ndarray:
        missing = [name for name in self.robot.joint_names if name not in names]
        if missing:
            raise HardwareError(
                f"the joint states lack '{missing[0]}' of '{self.robot.name}': this is another "
                "robot, or its joint_state_broadcaster leaves joints out"
            )
        return np.array([names.index(name) for name in self.robot.joint_names])

    def _on_imu(self, message: Any) -> None:
        self._imu = message
        self._pair()

    def _pair(self) -> None:
        """Make a reading of joint states and IMU of one instant."""
        joints, imu = self._joints, self._imu
        if joints is None or imu is None:
            return
        if abs(to_seconds(imu.header.stamp) - joints.time) > 0.5 * self.period:
            return
        self._imu = None
        if joints.time <= self._paired:
            self.connection.reordered += 1
            return
        self._paired = joints.time
        self.connection.received += 1
        rates, force, o = imu.angular_velocity, imu.linear_acceleration, imu.orientation
        measurement = Measurement(
            time=joints.time,
            joint_position=joints.position,
            joint_velocity=joints.velocity,
            gyro=np.array([rates.x, rates.y, rates.z]),
            accelerometer=np.array([force.x, force.y, force.z]),
            joint_torque=joints.torque,
        )
        self._readings.append(Reading(measurement, tilt_of(o.w, o.x, o.y, o.z)))

    def send(self, command: ServoCommand) -> None:
        """Send a command, without waiting; nothing before the first joint states."""
        joints, gains = self._joints, self._gains
        if joints is None:
            return
        q, v = joints.position, joints.velocity
        torque = np.clip(command.torque(q, v), -self._tau_max, self._tau_max)
        values = torque if gains is None else q + (torque + gains.kd * v) / gains.kp
        self._publish(values)

    def _publish(self, values: np.ndarray) -> None:
        self._publisher.publish(_ARRAY(data=values[self._order]))
        self.connection.sent += 1

    def damp(self) -> None:
        """Emergency stop: have all joints damped, at the velocities of the last joint states."""
        zero = np.zeros(self.robot.na)
        self.send(ServoCommand(zero, zero, zero, zero, self._damping))

    def release(self) -> None:
        """Let go: no effort, or the positions at which the joints are."""
        if self._joints is not None:
            efforts = self._gains is None
            self._publish(np.zeros(self.robot.na) if efforts else self._joints.position)

    def close(self) -> None:
        """Leave ROS 2."""
        self._node.close()
