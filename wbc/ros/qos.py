"""Quality of service: the policies and predefined profiles of ROS 2, and their DDS form."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclonedds.qos import Qos as DdsQos

_INFINITE = (1 << 63) - 1  # ns


class ReliabilityPolicy(Enum):
    """Whether lost messages are sent again."""

    RELIABLE = "reliable"
    BEST_EFFORT = "best effort"


class DurabilityPolicy(Enum):
    """Whether a late subscription receives messages that were published before it existed."""

    VOLATILE = "volatile"
    TRANSIENT_LOCAL = "transient local"


class HistoryPolicy(Enum):
    """The number of messages that are kept for a slow reader."""

    KEEP_LAST = "keep last"
    KEEP_ALL = "keep all"


@dataclass(frozen=True)
class QoSProfile:
    """The quality of service with which the messages of a topic are delivered.

    Attributes:
        depth: number of messages kept for a slow reader, summed over all writers; used with
            `HistoryPolicy.KEEP_LAST` only.
        reliability: whether lost messages are sent again.
        durability: whether late subscriptions receive earlier messages.
        history: whether to keep the last `depth` messages or all of them.
        lifespan: age above which a message is no longer delivered, s; None for no limit.
    """

    depth: int = 10
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST
    lifespan: float | None = None

    @staticmethod
    def of(qos_profile: QoSProfile | int) -> QoSProfile:
        """Return a profile as it is, or the default profile with the given depth."""
        return QoSProfile(depth=qos_profile) if isinstance(qos_profile, int) else qos_profile

    @property
    def reliable(self) -> bool:
        """Whether lost messages are sent again."""
        return self.reliability is ReliabilityPolicy.RELIABLE

    @property
    def transient_local(self) -> bool:
        """Whether late subscriptions receive earlier messages."""
        return self.durability is DurabilityPolicy.TRANSIENT_LOCAL

    def __str__(self) -> str:
        terms = [self.reliability.value, self.durability.value, self.history.value]
        if self.history is HistoryPolicy.KEEP_LAST:
            terms[-1] += f" {self.depth}"
        if self.lifespan is not None:
            terms.append(f"lifespan {self.lifespan:g} s")
        return ", ".join(terms)

    def __repr__(self) -> str:
        return f"QoSProfile({self})"

    def to_dds(self, user_data: str = "", ignore_local: bool = False) -> DdsQos:
        """Return the profile for Cyclone DDS, equal to what `rmw_cyclonedds` makes of it.

        Args:
            user_data: USER_DATA of the endpoint, visible to others at discovery.
            ignore_local: whether a reader ignores the writers of its own participant.
        """
        from cyclonedds.core import Policy
        from cyclonedds.core import Qos as DdsQos

        keep_all = self.history is HistoryPolicy.KEEP_ALL
        history = Policy.History.KeepAll if keep_all else Policy.History.KeepLast(self.depth)
        reliability, durability = Policy.Reliability, Policy.Durability
        policies = [
            history,
            reliability.Reliable(_INFINITE) if self.reliable else reliability.BestEffort,
            durability.TransientLocal if self.transient_local else durability.Volatile,
            Policy.WriterDataLifecycle(autodispose=False),
            Policy.Liveliness.Automatic(_INFINITE),
            Policy.DataRepresentation(
                use_cdrv0_representation=True, use_xcdrv2_representation=False
            ),
        ]
        if self.transient_local:
            # Cyclone DDS stores messages for late readers separately from those for slow readers.
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
        if ignore_local:
            policies.append(Policy.IgnoreLocal.Participant)
        if self.lifespan is not None:
            policies.append(Policy.Lifespan(round(1e9 * self.lifespan)))
        if user_data:
            policies.append(Policy.Userdata(user_data.encode()))
        return DdsQos(*policies)

    @staticmethod
    def from_dds(qos: DdsQos) -> QoSProfile:
        """Return a discovered quality of service; some DDS implementations omit the depth."""
        from cyclonedds.core import Policy

        def policy(kind: Any) -> Any:
            return qos[kind] if kind in qos else None  # noqa: SIM401  it has no get

        depth = getattr(policy(Policy.History), "depth", 0)
        reliable = policy(Policy.Reliability) not in (None, Policy.Reliability.BestEffort)
        volatile = policy(Policy.Durability) in (None, Policy.Durability.Volatile)
        lifespan = getattr(policy(Policy.Lifespan), "lifespan", _INFINITE)
        return QoSProfile(
            depth,
            ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            DurabilityPolicy.VOLATILE if volatile else DurabilityPolicy.TRANSIENT_LOCAL,
            HistoryPolicy.KEEP_LAST if depth else HistoryPolicy.KEEP_ALL,
            None if lifespan >= _INFINITE else 1e-9 * lifespan,
        )


#: Topics.
DEFAULT = QoSProfile()
#: Late subscriptions receive the last message.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
#: 0.2 s of messages at 500 Hz: more than a reader needs to ask for a lost message.
HIGH_RATE = QoSProfile(depth=100)
#: Requests, replies and parameter events: of many at once none is lost.
SERVICES = QoSProfile(depth=1000)
#: Reliable, hence compatible with best-effort subscriptions (those of `rclcpp`) and reliable ones.
CLOCK = QoSProfile(depth=1)
ROSOUT = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=10.0)
#: The type has no key, so that keeping the last message would keep one message of all writers.
DISCOVERY_INFO_OF_ALL = QoSProfile(
    durability=DurabilityPolicy.TRANSIENT_LOCAL, history=HistoryPolicy.KEEP_ALL
)
