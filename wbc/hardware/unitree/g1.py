"""A Unitree G1 over its low-level interface."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import ConnectionState, Reading, tilt_of
from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.motors import (
    G1_MACHINES,
    SERIES_MODE,
    SIMULATOR_MACHINE,
    motor_of_joint,
)
from wbc.hardware.unitree.transport import Transport
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.servo import ServoCommand

_TICK = 1e-3  # s per count of the robot's clock
_B_KEY = 0b10  # of the third byte of the remote control's keys
_DAMPING = 3.0  # N·m·s/rad in damping mode, for every joint
_WRAP = 1 << 32
_REST = 0.005  # s beyond the timeout for messages that wait and are no readings


class UnitreeG1:
    """A G1 with 29 joints, which is in its development mode (its own controller is off).

    Args:
        robot: its model.
        transport: the wire.
        period: period of the state messages, s.
        machines: values of `mode_machine` that are accepted. `SIMULATOR_MACHINE` among them admits
            simulators, also such as state no checksum and no time: their messages are timed by
            their arrival.

    Attributes:
        robot: its model.
        period: period of the state messages, s.
        connection: counters of the connection.

    Raises:
        HardwareError: the model is not that of a G1 with 29 joints.
    """

    def __init__(
        self,
        robot: Robot,
        transport: Transport,
        period: float = 0.002,
        machines: Collection[int] = G1_MACHINES,
    ) -> None:
        self.robot = robot
        self.period = period
        self.connection = ConnectionState()
        self._transport = transport
        self._motors = motor_of_joint(robot)
        self._state, self._command = MessageBuffer(LOW_STATE), MessageBuffer(LOW_COMMAND)
        self._command.fields["motor_cmd"]["mode"][0, self._motors] = 1  # servo on
        self._command.fields["mode_pr"] = SERIES_MODE
        self._machines = machines
        self._tick: int | None = None
        self._ticks = 0
        self._arrived: float | None = None  # s, of a message without a time
        self._timed_by_arrival = 0.0  # s

    def now(self) -> float:
        """Return the time of the clock of this computer, s."""
        return self._transport.now()

    def receive(self, timeout: float) -> Reading | None:
        """Return the oldest reading that was not returned yet; None after `timeout` s.

        Raises:
            HardwareError: the robot is no G1 with 29 joints.
        """
        end = self.now() + timeout
        while True:
            left = end - self.now()
            data = self._transport.receive(max(left, 0.0))
            if data is None:
                return None
            if not self._decode(data):
                self.connection.corrupt += 1
            elif self._advance_clock():
                self.connection.received += 1
                return self._reading()
            if left < -_REST:
                return None

    def _decode(self, data: bytes) -> bool:
        """Take in a state message; return whether it is whole."""
        if self._state.decode(data):
            return True
        return (
            SIMULATOR_MACHINE in self._machines
            and self._state.decode_without_checksum(data)
            and self._state.fields["mode_machine"][0] == SIMULATOR_MACHINE
        )

    def _advance_clock(self) -> bool:
        """Take in the robot's clock; return whether the message is newer than all before it."""
        state = self._state.fields
        machine = int(state["mode_machine"][0])
        if machine not in self._machines:
            what = (
                "a simulator; connect over the interface 'lo'"
                if machine == SIMULATOR_MACHINE
                else "another robot, and its motors have another order; disconnect it"
            )
            raise HardwareError(
                f"the robot reports mode_machine {machine}, a G1 with 29 joints "
                f"{' or '.join(map(str, G1_MACHINES))}: this is {what}"
            )
        self._command.fields["mode_machine"] = machine
        tick = int(state["tick"][0])
        if tick == 0 and machine == SIMULATOR_MACHINE:
            now = self.now()
            self._timed_by_arrival += 0.0 if self._arrived is None else now - self._arrived
            self._arrived, self._tick = now, 0
            return True
        if self._tick is not None:
            later = (tick - self._tick) % _WRAP
            if later == 0 or later > _WRAP // 2:
                self.connection.reordered += 1
                return False
            self._ticks += later
        self._tick = tick
        return True

    def _reading(self) -> Reading:
        imu = self._state.fields["imu_state"][0]
        states = self._state.fields["motor_state"][0]
        measurement = Measurement(
            time=_TICK * self._ticks + self._timed_by_arrival,
            joint_position=states["q"][self._motors].astype(float),
            joint_velocity=states["dq"][self._motors].astype(float),
            gyro=imu["gyroscope"].astype(float),
            accelerometer=imu["accelerometer"].astype(float),
            joint_torque=states["tau_est"][self._motors].astype(float),
        )
        pressed = bool(self._state.fields["wireless_remote"][0, 3] & _B_KEY)
        return Reading(measurement, tilt_of(*imu["quaternion"].tolist()), pressed)

    def send(self, command: ServoCommand) -> None:
        """Send a command to the servos, without waiting."""
        self._transport.send(self._encoded(command))
        self.connection.sent += 1

    def damp(self) -> None:
        """Emergency stop: have all joints damped, at once."""
        self._transport.send(self.damping_message())
        self.connection.sent += 1

    def damping_message(self) -> bytes:
        """Return the bytes of the command that damps all joints of this robot."""
        zero = np.zeros(self.robot.na)
        return self._encoded(ServoCommand(zero, zero, zero, zero, zero + _DAMPING))

    def _encoded(self, command: ServoCommand) -> bytes:
        commands, motors = self._command.fields["motor_cmd"][0], self._motors
        commands["q"][motors] = command.q
        commands["dq"][motors] = command.v
        commands["tau"][motors] = command.tau
        commands["kp"][motors] = command.kp
        commands["kd"][motors] = command.kd
        return self._command.encode()

    def close(self) -> None:
        """End the connection."""
        self._transport.close()
