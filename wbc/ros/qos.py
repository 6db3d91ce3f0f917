"""Quality of service: the profiles of ROS 2, and what they are in DDS."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cyclonedds.qos import Qos as DdsQos


@dataclass(frozen=True)
class Qos:
    """How a topic's messages are delivered.

    Attributes:
        depth: messages that are kept for a reader that is slow, of all writers together; 0: all.
        reliable: lost messages are sent again.
        latched: late readers get what was sent before (transient local).
        lifespan: after which a message is no longer delivered, s; None: never.
    """

    depth: int = 10
    reliable: bool = True
    latched: bool = False
    lifespan: float | None = None

    def to_dds(self, user_data: str = "") -> DdsQos:
        """As Cyclone DDS takes it: what `rmw_cyclonedds` makes of the same profile.

        Args:
            user_data: what the endpoint tells about itself at discovery.
        """
        from cyclonedds.core import Policy
        from cyclonedds.core import Qos as DdsQos
        from cyclonedds.util import duration

        history = Policy.History.KeepLast(self.depth) if self.depth else Policy.History.KeepAll
        policies = [
            history,
            Policy.Reliability.Reliable(duration(infinite=True))
            if self.reliable
            else Policy.Reliability.BestEffort,
            Policy.Durability.TransientLocal if self.latched else Policy.Durability.Volatile,
            Policy.WriterDataLifecycle(autodispose=False),
            Policy.Liveliness.Automatic(duration(infinite=True)),
            Policy.DataRepresentation(
                use_cdrv0_representation=True, use_xcdrv2_representation=False
            ),
        ]
        if self.latched:
            # Cyclone keeps what late readers get apart from what slow readers get.
            unlimited = -1
            policies.append(
                Policy.DurabilityService(
                    cleanup_delay=0,
                    history=history,
                    max_samples=unlimited,
                    max_instances=unlimited,
                    max_samples_per_instance=unlimited,
                )
            )
        if self.lifespan is not None:
            policies.append(Policy.Lifespan(duration(seconds=self.lifespan)))
        if user_data:
            policies.append(Policy.Userdata(user_data.encode()))
        return DdsQos(*policies)


DEFAULT = Qos()
LATCHED = Qos(depth=1, latched=True)
#: At 500 Hz a fifth of a second: longer than a reader takes to ask for what it missed.
FAST = Qos(depth=100)
SENSOR_DATA = Qos(depth=5, reliable=False)
SERVICES = Qos()
PARAMETERS = Qos(depth=1000)
PARAMETER_EVENTS = Qos(depth=1000)
#: Reliable, so that it suits both who asks for that and who, as `rclcpp`'s nodes, does not.
CLOCK = Qos(depth=1)
ROSOUT = Qos(depth=1000, latched=True, lifespan=10.0)
TF = Qos(depth=100)
ACTION_STATUS = LATCHED
DISCOVERY_INFO = LATCHED
#: Without keys the last message is the last of anyone: who reads of each, keeps them all.
DISCOVERY_INFO_OF_ALL = Qos(depth=0, latched=True)
