"""The wire to a Unitree robot: two DDS topics."""

from __future__ import annotations

import os
import resource
import time
from collections import deque
from dataclasses import replace
from typing import Any, Protocol

from wbc.hardware.unitree.messages import COMMAND_TOPIC, STATE_TOPIC, dds_type
from wbc.ros.dds_endpoints import DdsReader, DdsWriter, EndpointConfig
from wbc.ros.network import DiscoveryRange, Network
from wbc.ros.qos import QoSProfile, ReliabilityPolicy

#: As the maker's SDK: a lost message is not sent again, because the next one is newer.
_READER = QoSProfile(depth=64, reliability=ReliabilityPolicy.BEST_EFFORT)
_WRITER = QoSProfile(depth=1)


_THREADS = ("recv", "recvUC", "recvMC", "tev")  # of Cyclone DDS, which carry the messages
_PRIORITY = 45  # above the loop, which waits for them


def _thread_configuration() -> str:
    """Return the configuration that gives the threads of DDS a real-time priority, if allowed."""
    if os.geteuid() != 0 and resource.getrlimit(resource.RLIMIT_RTPRIO)[0] < _PRIORITY:
        return ""
    threads = "".join(
        f'<Thread Name="{name}"><Scheduling><Class>realtime</Class><Priority>{_PRIORITY}</Priority>'
        "</Scheduling></Thread>"
        for name in _THREADS
    )
    return f"<CycloneDDS><Domain><Threads>{threads}</Threads></Domain></CycloneDDS>"


def unitree_network(interface: str) -> Network:
    """Return the DDS network of a Unitree robot, domain 0 of an interface.

    The maker's SDK discovers by multicast, on the loopback as well.

    Args:
        interface: name or address of the interface.
    """
    peers = ("127.0.0.1",) if interface == "lo" else ()
    return Network(0, DiscoveryRange.SUBNET, interface, peers)


class Transport(Protocol):
    """Carries the bytes of messages, of the controller's or of the robot's side."""

    def now(self) -> float:
        """Return the time of this side's clock, s."""

    def receive(self, timeout: float) -> bytes | None:
        """Return the oldest message that was not returned yet; None after `timeout` s."""

    def send(self, data: bytes) -> None:
        """Send a message, without waiting."""

    def close(self) -> None:
        """Leave the wire."""


class DdsTransport:
    """A DDS participant that writes one of the topics and reads the other.

    Args:
        network: DDS domain and network interface. A robot is in domain 0.
        robot_side: write states and read commands, as the robot does.

    Raises:
        MissingExtra: `cyclonedds` is not installed.
        RosError: the domain cannot be joined.
    """

    def __init__(self, network: Network, *, robot_side: bool = False) -> None:
        state, command = dds_type("LowState_"), dds_type("LowCmd_")
        from cyclonedds.core import WaitSet
        from cyclonedds.domain import DomainParticipant

        configuration = ",".join(filter(None, (network.configuration, _thread_configuration())))
        self._domain = replace(network, configuration=configuration).join()
        self._participant: Any = DomainParticipant(network.domain_id)
        received, sent = (COMMAND_TOPIC, command), (STATE_TOPIC, state)
        if not robot_side:
            received, sent = sent, received
        self._writer = DdsWriter(self._participant, EndpointConfig(*sent, _WRITER))
        self._reader = DdsReader(self._participant, EndpointConfig(*received, _READER))
        self._wait_set = WaitSet(self._participant)
        self._wait_set.attach(self._reader.condition)
        self._taken: deque[bytes] = deque()

    def now(self) -> float:
        """Return the time of the performance counter, s."""
        return time.perf_counter()

    def receive(self, timeout: float) -> bytes | None:
        """Return the oldest message that was not returned yet; None after `timeout` s."""
        if not self._taken:
            self._taken.extend(data for data, _ in self._reader.take())
            if not self._taken and timeout > 0.0:
                self._wait_set.wait(round(1e9 * timeout))
                self._taken.extend(data for data, _ in self._reader.take())
        return self._taken.popleft() if self._taken else None

    def send(self, data: bytes) -> None:
        """Send a message, without waiting."""
        self._writer.write(data)

    @property
    def connected(self) -> bool:
        """Whether somebody reads what this side writes."""
        return bool(self._writer.matched)

    def close(self) -> None:
        """Leave the wire; the others are notified at once."""
        self._reader.close()
        self._participant.__del__()
