"""DDS domain and network interfaces of a node; this machine only by default."""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any
from xml.sax.saxutils import quoteattr

from wbc.ros.errors import RosError

MAX_DOMAIN_ID = 232  #: with the standard ports, 7400 + 250 × domain id, below 65536
_LOOPBACK = "127.0.0.1"
#: Types are matched by name, as in ROS 2; a participant counts as dead after 5 s of silence; the
#: memory of a message is bounded.
_BASE_CONFIGURATION = (
    "<CycloneDDS><Domain>"
    "<Compatibility><IgnoreTypeInformation>1.1,1.15,1.16</IgnoreTypeInformation></Compatibility>"
    "<Discovery><LeaseDuration>5 s</LeaseDuration></Discovery>"
    "<Internal><MaxSampleSize>64 MiB</MaxSampleSize></Internal>"
    "</Domain></CycloneDDS>"
)
_MAX_PARTICIPANT_INDEX = 32  # participants to discover on one machine; the value of ROS 2


class DiscoveryRange(Enum):
    """The range of discovery, as `ROS_AUTOMATIC_DISCOVERY_RANGE` in ROS 2.

    Cyclone DDS uses one interface unless told otherwise, and drops what arrives on another one.
    Nodes of this machine may use any of its interfaces, and all of them reach the loopback
    interface: both LOCALHOST and SUBNET include it.
    """

    LOCALHOST = "localhost"  #: this machine only; no multicast
    SUBNET = "subnet"  #: this machine and every host that multicast reaches
    SYSTEM_DEFAULT = "system_default"  #: as configured by `CYCLONEDDS_URI`
    OFF = "off"  #: no other process


@dataclass(frozen=True)
class Network:
    """DDS domain and network interface of a node.

    Attributes:
        domain_id: id of the DDS domain, `ROS_DOMAIN_ID`.
        discovery_range: range of discovery.
        interface: name or address of the only network interface to use; if empty,
            `discovery_range` selects the interfaces.
        peers: addresses of further hosts to discover.
        configuration: configuration of Cyclone DDS, XML or the path of a file; it overrides all
            other settings.

    Raises:
        RosError: the domain id is out of range.
    """

    domain_id: int = 0
    discovery_range: DiscoveryRange = DiscoveryRange.LOCALHOST
    interface: str = ""
    peers: tuple[str, ...] = ()
    configuration: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.domain_id <= MAX_DOMAIN_ID:
            raise RosError(f"domain id {self.domain_id} is out of range; use 0 to {MAX_DOMAIN_ID}")

    def __repr__(self) -> str:
        return f"Network(domain_id={self.domain_id}, {self.scope})"

    @staticmethod
    def from_environment(
        domain_id: int | None = None,
        interface: str | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> Network:
        """Return the network that the environment variables of ROS 2 select.

        `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY`, `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_STATIC_PEERS`
        and `CYCLONEDDS_URI` are respected. Without any of them the range is this machine, whereas
        that of ROS 2 is the subnet.

        Args:
            domain_id: overrides `ROS_DOMAIN_ID`.
            interface: name or address; overrides all variables that select an interface.
            environment: the variables; `os.environ` by default.

        Raises:
            RosError: a variable has an invalid value.
        """
        environment = os.environ if environment is None else environment
        if domain_id is None:
            domain_id = _parse_domain_id(environment.get("ROS_DOMAIN_ID", "") or "0")
        if interface == "lo" or (interface is not None and _is_loopback(interface)):
            return Network(domain_id)
        if interface is not None:
            return Network(domain_id, DiscoveryRange.SUBNET, interface)
        uri = environment.get("CYCLONEDDS_URI", "")
        peers = tuple(
            filter(None, map(str.strip, environment.get("ROS_STATIC_PEERS", "").split(";")))
        )
        default = DiscoveryRange.SYSTEM_DEFAULT if uri else DiscoveryRange.LOCALHOST
        discovery_range = _parse_range(environment) or default
        return Network(domain_id, discovery_range, "", peers, uri)

    def xml(self) -> str:
        """Return the Cyclone DDS configuration for this network, for all versions ROS 2 ships."""
        scope = self.discovery_range
        if scope is DiscoveryRange.SYSTEM_DEFAULT:
            return self.configuration
        general, peers = "", self.peers
        if scope is DiscoveryRange.OFF:
            peers = ()
            discovery = f"<ParticipantIndex>none</ParticipantIndex><Tag>off_{os.getpid()}</Tag>"
        else:
            discovery = (
                "<ParticipantIndex>auto</ParticipantIndex>"
                f"<MaxAutoParticipantIndex>{_MAX_PARTICIPANT_INDEX}</MaxAutoParticipantIndex>"
            )
            general = "".join(f"<NetworkInterface {one}/>" for one in self._interfaces())
            general = f"<Interfaces>{general}</Interfaces>"
            if not self.interface:
                peers = (_LOOPBACK, *peers)
        if scope is not DiscoveryRange.SUBNET:
            general += "<AllowMulticast>false</AllowMulticast>"
        if peers:
            addresses = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
            discovery += f"<Peers>{addresses}</Peers>"
        xml = (
            f"<CycloneDDS><Domain><General>{general}</General>"
            f"<Discovery>{discovery}</Discovery></Domain></CycloneDDS>"
        )
        return ",".join(filter(None, (xml, self.configuration)))

    def _interfaces(self) -> list[str]:
        """Return the attributes of the interfaces in the configuration."""
        if self.interface:
            key = "address" if _is_address(self.interface) else "name"
            return [f"{key}={quoteattr(self.interface)}"]
        loopback = f'address="{_LOOPBACK}"'
        stays = self.discovery_range is DiscoveryRange.LOCALHOST and not self._remote_peers
        # On a machine with no other interface Cyclone DDS would determine this one, and refuses to
        # use it twice.
        if stays or not _has_other_interface():
            return [loopback]
        return ['autodetermine="true"', loopback]

    @property
    def _remote_peers(self) -> tuple[str, ...]:
        return tuple(peer for peer in self.peers if not _is_loopback(peer))

    @property
    def scope(self) -> str:
        """Which nodes can be met, in a few words."""
        if self.interface:
            return f"interface {self.interface} only"
        words = {
            DiscoveryRange.LOCALHOST: ", ".join(("this machine only", *self._remote_peers)),
            DiscoveryRange.SUBNET: "the subnet",
            DiscoveryRange.SYSTEM_DEFAULT: "as Cyclone DDS is configured",
            DiscoveryRange.OFF: "no other process",
        }
        return words[self.discovery_range]

    @property
    def hint(self) -> str:
        """What to try when no other node is met."""
        if self.discovery_range is DiscoveryRange.OFF:
            return "discovery is off: unset ROS_AUTOMATIC_DISCOVERY_RANGE"
        return (
            f"DDS domain {self.domain_id}, {self.scope}; the other side needs the same "
            "ROS_DOMAIN_ID, RMW_IMPLEMENTATION=rmw_cyclonedds_cpp and "
            'ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, or CYCLONEDDS_URI="$(wbc ros2 uri)"'
        )

    def join(self) -> Any:
        """Join the DDS domain, until the process ends; return Cyclone's domain object.

        Raises:
            RosError: this process has already joined the domain with another configuration.
        """
        return _join(self.domain_id, ",".join(filter(None, (_BASE_CONFIGURATION, self.xml()))))


def _parse_domain_id(text: str) -> int:
    if not text.isdecimal():
        raise RosError(f"ROS_DOMAIN_ID is '{text}'; it must be a number, 0 to {MAX_DOMAIN_ID}")
    return int(text)


def _parse_range(environment: Mapping[str, str]) -> DiscoveryRange | None:
    """Return the range that the variables select; the older one takes precedence, as in ROS 2."""
    localhost_only = environment.get("ROS_LOCALHOST_ONLY", "")
    if localhost_only:
        return DiscoveryRange.LOCALHOST if localhost_only == "1" else DiscoveryRange.SUBNET
    text = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    try:
        return DiscoveryRange(text.lower()) if text else None
    except ValueError:
        raise RosError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is '{text}'; it must be LOCALHOST, SUBNET, "
            "SYSTEM_DEFAULT or OFF"
        ) from None


def _is_address(text: str) -> bool:
    return text.replace(".", "").isdecimal() or ":" in text


def _is_loopback(host: str) -> bool:
    return host == "localhost" or host.startswith("127.")


def _has_other_interface() -> bool:
    """Return whether an interface other than loopback is up and has an IPv4 address."""
    if sys.platform != "linux":
        return True
    import fcntl

    get_flags, get_address, up, is_loopback = 0x8913, 0x8915, 0x1, 0x8  # <linux/sockios.h>, if.h
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        for _, name in socket.if_nameindex():
            request = struct.pack("16s24x", name.encode())
            with contextlib.suppress(OSError):  # it has no address, or has just gone
                flags = int.from_bytes(
                    fcntl.ioctl(any_socket, get_flags, request)[16:18], sys.byteorder
                )
                fcntl.ioctl(any_socket, get_address, request)
                if flags & up and not flags & is_loopback:
                    return True
    return False


@cache
def _join(domain_id: int, xml: str) -> Any:
    from cyclonedds.core import DDSException
    from cyclonedds.domain import Domain

    try:
        return Domain(domain_id, xml)
    except DDSException as error:
        reason = (
            "this process has joined it with another configuration"
            if error.code == DDSException.DDS_RETCODE_PRECONDITION_NOT_MET
            else f"{error}; check CYCLONEDDS_URI, and that the network interface exists"
        )
        raise RosError(f"DDS domain {domain_id} cannot be joined: {reason}") from error
