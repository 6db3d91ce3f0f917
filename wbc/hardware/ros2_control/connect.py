"""Connects to a robot that `ros2_control` drives."""

from __future__ import annotations

from wbc.hardware.ros2_control.guard import DampingRequest, Ros2GuardConfig
from wbc.hardware.ros2_control.robot import Ros2ControlConfig, Ros2ControlRobot
from wbc.process import ChildProcess
from wbc.robot import Robot
from wbc.ros.network import Network
from wbc.ros.node import Node
from wbc.servo import ServoCommand


class GuardedRos2ControlRobot(Ros2ControlRobot):
    """A `Ros2ControlRobot`, whose joints a second process damps after a fault or this one's death.

    Args:
        robot: its model.
        network: DDS domain and network interface.
        config: names and properties of its controllers.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the domain cannot be joined.
        ProcessStartError: the second process did not start.
    """

    def __init__(self, robot: Robot, network: Network, config: Ros2ControlConfig) -> None:
        super().__init__(robot, Node("wbc_hardware", network=network), config)
        self._guard = ChildProcess("wbc.hardware.ros2_control.guard", title="the guard")
        self._guard.configure(Ros2GuardConfig(robot, network, config))
        self._damped = False

    def send(self, command: ServoCommand) -> None:
        """Send a command, without waiting."""
        self._request(active=False)
        super().send(command)

    def damp(self) -> None:
        """Emergency stop: have all joints damped, from now on by the second process as well."""
        self._request(active=True)
        zero = self._damping * 0.0
        super().send(ServoCommand(zero, zero, zero, zero, self._damping))

    def _request(self, *, active: bool) -> None:
        if active != self._damped:
            self._damped = active
            self._guard.send(DampingRequest(active))

    def close(self) -> None:
        """End the connection; the second process goes on damping for a second and a half."""
        self._guard.close()
        super().close()


def connect(
    robot: Robot, config: Ros2ControlConfig | None = None, network: Network | None = None
) -> GuardedRos2ControlRobot:
    """Connect to a robot that `ros2_control` drives.

    Args:
        robot: its model.
        config: names and properties of its controllers and broadcasters.
        network: DDS domain and network interface; `Network.from_environment()` by default.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the DDS domain cannot be joined.
        HardwareError: the configuration does not fit the model.
    """
    network = network or Network.from_environment()
    return GuardedRos2ControlRobot(robot, network, config or Ros2ControlConfig())
