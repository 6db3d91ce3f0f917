"""Connects to a Unitree G1 over the network."""

from __future__ import annotations

from collections.abc import Collection

from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import Reading
from wbc.hardware.period import measured_period
from wbc.hardware.unitree.g1 import UnitreeG1
from wbc.hardware.unitree.guard import DampingMessage, GuardConfig
from wbc.hardware.unitree.motors import G1_MACHINES, SIMULATOR_MACHINE
from wbc.hardware.unitree.transport import DdsTransport, unitree_network
from wbc.process import ChildProcess
from wbc.robot import Robot, load
from wbc.ros.network import Network


class GuardedG1(UnitreeG1):
    """A G1 over DDS, whose joints a second process damps when this one has gone.

    Args:
        robot: its model.
        network: DDS domain and network interface.
        machines: see `UnitreeG1`.

    Raises:
        HardwareError: there is no robot, or not the expected one.
        MissingExtra: `cyclonedds` is not installed.
        RosError: the domain cannot be joined.
        ProcessStartError: the second process did not start.
    """

    def __init__(
        self, robot: Robot, network: Network, machines: Collection[int] = G1_MACHINES
    ) -> None:
        super().__init__(robot, DdsTransport(network), machines=machines)
        self._guard = ChildProcess("wbc.hardware.unitree.guard", title="the guard")
        self._guard.configure(GuardConfig(network))
        self._knows_damping = False
        try:
            self.period = measured_period(self)
        except HardwareError:
            self.close()
            raise

    def receive(self, timeout: float) -> Reading | None:
        """See `UnitreeG1.receive`; the first reading makes the guard ready."""
        reading = super().receive(timeout)
        if reading is not None and not self._knows_damping:
            self._knows_damping = True
            self._guard.send(DampingMessage(self.damping_message()))
        return reading

    def close(self) -> None:
        """End the connection; the guard goes on damping for a second."""
        self._guard.close()
        super().close()


def connect(interface: str = "lo", robot: Robot | None = None) -> GuardedG1:
    """Connect to a G1 with 29 joints in its development mode.

    Args:
        interface: name or address of the network interface that leads to the robot; `lo` for a
            stand-in robot on this computer.
        robot: its model; that of `wbc.load("g1")` by default.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the DDS domain cannot be joined over the interface.
        HardwareError: the model is not that of a G1 with 29 joints, there is no robot, or it is
            another one.
    """
    machines = (*G1_MACHINES, SIMULATOR_MACHINE) if interface == "lo" else G1_MACHINES
    return GuardedG1(robot or load("g1"), unitree_network(interface), machines)
