"""A process that damps the joints of a `ros2_control` robot, also when its parent has gone.

`wbc.hardware.ros2_control.connect` starts it as `python -m wbc.hardware.ros2_control.guard`; see
`wbc.process.child`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from wbc.errors import WbcError
from wbc.hardware.ros2_control.robot import Ros2ControlConfig, Ros2ControlRobot
from wbc.process import ParentConnection
from wbc.robot import Robot
from wbc.ros.network import Network
from wbc.ros.node import Node

_WAIT = 0.02  # s, for joint states
_DAMPING_TIME = 1.5  # s for which the joints are damped after the parent has gone


@dataclass(frozen=True)
class Ros2GuardConfig:
    """Configuration of the process.

    Attributes:
        robot: the model.
        network: DDS domain and network interface.
        config: names and properties of the robot's controllers.
    """

    robot: Robot
    network: Network
    config: Ros2ControlConfig


@dataclass(frozen=True)
class DampingRequest:
    """Whether the process is to damp the joints from now on.

    Attributes:
        active: whether it is.
    """

    active: bool


def main() -> None:
    """Damp the joints while the parent wishes, and when it has gone; then let go."""
    parent = ParentConnection()
    config: Ros2GuardConfig = parent.config
    try:
        node = Node("wbc_guard", network=config.network)
        hardware = Ros2ControlRobot(config.robot, node, config.config)
    except WbcError as error:
        parent.reply({"error": str(error)})
        return
    requests = [DampingRequest(False)]
    parent.listen(requests.append)
    parent.reply({"ready": True})
    while not parent.gone:
        hardware.receive(_WAIT)
        if requests[-1].active:
            hardware.damp()
    end = time.monotonic() + _DAMPING_TIME
    while time.monotonic() < end:
        hardware.receive(_WAIT)
        hardware.damp()
    hardware.release()
    hardware.close()


if __name__ == "__main__":
    main()
