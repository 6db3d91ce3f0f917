"""Which DDS domain a node joins, and through which network interface: loopback unless told."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any
from xml.sax.saxutils import quoteattr

from wbc.ros.errors import RosError

LARGEST_DOMAIN = 232  #: with the usual ports, 7400 + 250 × domain, below 65536
_LOOPBACK = "127.0.0.1"
#: Types are matched by name, as ROS 2 does; a participant that is silent for so long is dead; no
#: message can take more memory than that.
_OWN = (
    "<CycloneDDS><Domain>"
    "<Compatibility><IgnoreTypeInformation>1.1,1.15,1.16</IgnoreTypeInformation></Compatibility>"
    "<Discovery><LeaseDuration>5 s</LeaseDuration></Discovery>"
    "<Internal><MaxSampleSize>64 MiB</MaxSampleSize></Internal>"
    "</Domain></CycloneDDS>"
)
_PARTICIPANTS = 32  # that are looked for on one machine, as ROS 2 does


class Reach(Enum):
    """How far a node looks for others, after `ROS_AUTOMATIC_DISCOVERY_RANGE`."""

    LOOPBACK = "loopback"  #: the loopback interface alone
    LOCALHOST = "localhost"  #: this machine, in the way of ROS 2: any interface, no multicast
    SUBNET = "subnet"  #: whoever multicast reaches
    SYSTEM_DEFAULT = "system_default"  #: as `CYCLONEDDS_URI` has it
    OFF = "off"  #: nobody


@dataclass(frozen=True)
class Network:
    """Where a node looks for others.

    Attributes:
        domain: id of the DDS domain, `ROS_DOMAIN_ID`.
        reach: how far it looks.
        interface: name or address of a network interface; empty leaves it to `reach`.
        peers: addresses to look at besides.
        configuration: Cyclone DDS's own, XML or the path of a file, which has the last word.

    Raises:
        RosError: the domain is out of range.
    """

    domain: int = 0
    reach: Reach = Reach.LOOPBACK
    interface: str = ""
    peers: tuple[str, ...] = ()
    configuration: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= LARGEST_DOMAIN:
            raise RosError(
                f"domain {self.domain} is out of range; ROS_DOMAIN_ID goes from 0 to "
                f"{LARGEST_DOMAIN}"
            )

    @staticmethod
    def of(
        domain: int | None = None,
        interface: str | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> Network:
        """What options and the usual environment variables ask for; options go first.

        Args:
            domain: instead of `ROS_DOMAIN_ID`.
            interface: name or address; instead of everything else that says how far to reach.
            environment: `os.environ` when left out. `ROS_DOMAIN_ID`, `ROS_LOCALHOST_ONLY`,
                `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_STATIC_PEERS` and `CYCLONEDDS_URI` count.

        Raises:
            RosError: a variable has a value that makes no sense.
        """
        environment = os.environ if environment is None else environment
        if domain is None:
            domain = _domain(environment.get("ROS_DOMAIN_ID", ""))
        if interface is not None:
            return Network(domain, *_through(interface))
        uri = environment.get("CYCLONEDDS_URI", "")
        reach = _reach(environment)
        if reach is None:
            reach = Reach.SYSTEM_DEFAULT if uri else Reach.LOOPBACK
        peers = tuple(p for p in environment.get("ROS_STATIC_PEERS", "").split(";") if p.strip())
        if peers and reach is Reach.LOOPBACK:
            reach = Reach.LOCALHOST
        return Network(domain, reach, "", peers, uri)

    def xml(self) -> str:
        """The configuration that brings Cyclone DDS here, of any version that ROS 2 has."""
        if self.reach is Reach.SYSTEM_DEFAULT:
            return self.configuration
        general, discovery = "", ""
        interface = _LOOPBACK if self.reach is Reach.LOOPBACK else self.interface
        if interface:
            kind = "address" if _is_address(interface) else "name"
            general += f"<Interfaces><NetworkInterface {kind}={quoteattr(interface)}/></Interfaces>"
        if self.reach is not Reach.SUBNET:
            general += "<AllowMulticast>false</AllowMulticast>"
        if self.reach is Reach.OFF:
            discovery = f"<ParticipantIndex>none</ParticipantIndex><Tag>off_{os.getpid()}</Tag>"
        else:
            discovery = (
                "<ParticipantIndex>auto</ParticipantIndex>"
                f"<MaxAutoParticipantIndex>{_PARTICIPANTS}</MaxAutoParticipantIndex>"
            )
        peers = self.peers if self.reach is not Reach.OFF else ()
        if self.reach in (Reach.LOOPBACK, Reach.LOCALHOST):
            peers = (_LOOPBACK, *peers)
        if peers:
            listed = "".join(f"<Peer address={quoteattr(p.strip())}/>" for p in peers)
            discovery += f"<Peers>{listed}</Peers>"
        own = (
            f"<CycloneDDS><Domain><General>{general}</General>"
            f"<Discovery>{discovery}</Discovery></Domain></CycloneDDS>"
        )
        return f"{own},{self.configuration}" if self.configuration else own

    def join(self) -> Any:
        """The DDS domain, ready for participants. It stays until the process ends.

        Raises:
            RosError: this process is in the domain already, with another configuration.
        """
        return _join(self.domain, ",".join(filter(None, (_OWN, self.xml()))))


def _domain(text: str) -> int:
    if not text:
        return 0
    if not text.isdecimal():
        raise RosError(f"ROS_DOMAIN_ID is '{text}'; it must be a number, 0 to {LARGEST_DOMAIN}")
    return int(text)


def _reach(environment: Mapping[str, str]) -> Reach | None:
    """What the variables of ROS 2 ask for; the older one has precedence, as there."""
    only = environment.get("ROS_LOCALHOST_ONLY", "")
    if only:
        return Reach.LOCALHOST if only == "1" else Reach.SUBNET
    text = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    if not text:
        return None
    try:
        return Reach(text.lower())
    except ValueError:
        raise RosError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE is '{text}'; it may be LOCALHOST, SUBNET, "
            "SYSTEM_DEFAULT or OFF"
        ) from None


def _through(interface: str) -> tuple[Reach, str]:
    if interface in ("lo", _LOOPBACK, "localhost"):
        return Reach.LOOPBACK, ""
    return Reach.SUBNET, interface


def _is_address(text: str) -> bool:
    return text.replace(".", "").isdecimal() or ":" in text


@cache
def _join(domain: int, xml: str) -> Any:
    from cyclonedds.core import DDSException
    from cyclonedds.domain import Domain

    try:
        return Domain(domain, xml)
    except DDSException as error:
        why = (
            "this process has joined it with another configuration"
            if error.code == DDSException.DDS_RETCODE_PRECONDITION_NOT_MET
            else f"{error}; look at CYCLONEDDS_URI, and whether the network interface exists"
        )
        raise RosError(f"DDS domain {domain} cannot be joined: {why}") from error
