"""The process that damps a G1's joints when the controller's process is killed."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest
from processtools import gone, wait_until

from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.transport import DdsTransport
from wbc.ros import Network

pytest.importorskip("cyclonedds")

CONTROLLER = """
import sys, time
from dataclasses import replace
import numpy as np
from wbc.hardware.unitree.connect import GuardedG1
from wbc.robot import load
from wbc.ros import Network
from wbc.servo import ServoCommand

robot = GuardedG1(load("g1"), replace(Network(), domain_id=int(sys.argv[1])))
print(robot._guard.pid, flush=True)
gain = np.ones(29)
while True:
    robot.send(ServoCommand(gain, gain, gain, 50.0 * gain, gain))
    time.sleep(0.01)
"""


class RobotSide:
    """The wire of a robot, which sends states and remembers the last command."""

    def __init__(self, domain: int) -> None:
        network = replace(Network(), domain_id=domain)
        self.transport = DdsTransport(network, robot_side=True)
        self._state, self.command = MessageBuffer(LOW_STATE), MessageBuffer(LOW_COMMAND)
        self._state.fields["mode_machine"] = 5
        self.received = 0

    def exchange(self) -> None:
        self._state.fields["tick"] += 2
        self.transport.send(self._state.encode())
        while (data := self.transport.receive(0.0)) is not None:
            assert self.command.decode(data)
            self.received += 1

    @property
    def gains(self) -> tuple[set[float], set[float]]:
        """The gains kp and kd of the 29 motors in the last command."""
        motors = self.command.fields["motor_cmd"][0, :29]
        return set(motors["kp"].tolist()), set(motors["kd"].tolist())


def test_a_second_process_damps_the_joints_of_a_controller_that_is_killed(domain) -> None:
    robot = RobotSide(domain)
    controller = subprocess.Popen(
        [sys.executable, "-c", CONTROLLER, str(domain)], stdout=subprocess.PIPE, text=True
    )

    def commanded() -> bool:
        robot.exchange()
        return robot.received > 0 and robot.gains == ({50.0}, {1.0})

    def damped() -> bool:
        robot.exchange()
        return robot.gains == ({0.0}, {3.0})

    try:
        wait_until(commanded, 60.0)
        guard = int(controller.stdout.readline())
    finally:
        controller.kill()
        controller.wait()
    received = robot.received
    wait_until(damped)
    assert robot.received > received
    wait_until(lambda: gone(guard))
    robot.transport.close()
