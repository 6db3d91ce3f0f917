"""DDS writers and readers of serialized messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from wbc.ros.errors import RosError
from wbc.ros.qos import QoSProfile

_BATCH = 256  # samples taken at once


@dataclass(frozen=True)
class EndpointConfig:
    """Properties of a writer or reader.

    Attributes:
        topic: DDS name of the topic.
        sample_type: class of the samples, see `wbc.ros.dds_types`.
        qos_profile: quality of service.
        user_data: USER_DATA, visible to others at discovery.
        ignore_local: whether a reader ignores the writers of its own participant.
    """

    topic: str
    sample_type: Any
    qos_profile: QoSProfile
    user_data: str = ""
    ignore_local: bool = False

    def create(self, entity_type: Any, participant: Any) -> Any:
        """Create a writer or reader of Cyclone DDS."""
        from cyclonedds.topic import Topic

        topic = Topic(participant, self.topic, self.sample_type)
        qos = self.qos_profile.to_dds(self.user_data, self.ignore_local)
        return entity_type(participant, topic, qos=qos)


@dataclass(frozen=True, slots=True)
class MessageInfo:
    """Metadata of a received message.

    Attributes:
        source_timestamp: time of sending by the writer's clock, s since 1970.
        writer: handle of the writer in this process.
        size: size of the serialized message, bytes, including the CDR header.
    """

    source_timestamp: float
    writer: int
    size: int


class DdsWriter:
    """Sends serialized messages on a DDS topic.

    Args:
        participant: domain participant of Cyclone DDS.
        config: properties of the writer.

    Attributes:
        dds: the data writer of Cyclone DDS.
        handle: instance handle, as samples carry it.
        gid: 16-byte id.
    """

    def __init__(self, participant: Any, config: EndpointConfig) -> None:
        from cyclonedds.pub import DataWriter

        self._sample = config.sample_type()
        self.dds = config.create(DataWriter, participant)
        self.handle = _unsigned(self.dds.instance_handle)
        self.gid: bytes = self.dds.guid.bytes

    def write(self, data: Any) -> None:
        """Send a serialized message, CDR header included.

        Raises:
            RosError: the bytes are no message of the topic's type, or DDS refuses to send them.
        """
        from cyclonedds.core import DDSException

        self._sample.data = data  # Cyclone DDS pads it with zeros to a multiple of four bytes
        try:
            self.dds.write(self._sample)
        except DDSException as error:
            raise RosError(f"{len(data)} bytes could not be sent: {error}") from error

    @property
    def matched(self) -> list[int]:
        """Handles of the matched readers."""
        return _matched(self.dds.get_matched_subscriptions)

    def matched_user_data(self) -> dict[int, dict[str, str]]:
        """Return the USER_DATA of the matched readers, by their handles."""
        return _user_data(self.matched, self.dds.get_matched_subscription_data)


class DdsReader:
    """Receives serialized messages from a DDS topic; see `DdsWriter` for the arguments.

    Attributes:
        dds: the data reader of Cyclone DDS.
        gid: 16-byte id.
        condition: read condition for a wait set, true while there are samples.
    """

    def __init__(self, participant: Any, config: EndpointConfig) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader

        self.dds = config.create(DataReader, participant)
        self.gid: bytes = self.dds.guid.bytes
        any_state = SampleState.Any | ViewState.Any | InstanceState.Any
        self.condition = ReadCondition(self.dds, any_state)

    def take(self) -> list[tuple[bytes, MessageInfo]]:
        """Return the messages received since the last call."""
        taken = []
        for sample in self.dds.take(_BATCH):
            info = sample.sample_info
            if info.valid_data:  # otherwise it only says that a writer has left
                timestamp = 1e-9 * info.source_timestamp
                message = MessageInfo(timestamp, info.publication_handle, len(sample.data))
                taken.append((sample.data, message))
        return taken

    @property
    def matched(self) -> list[int]:
        """Handles of the matched writers."""
        return _matched(self.dds.get_matched_publications)

    def matched_user_data(self) -> dict[int, dict[str, str]]:
        """Return the USER_DATA of the matched writers, by their handles."""
        return _user_data(self.matched, self.dds.get_matched_publication_data)

    def close(self) -> None:
        """Leave DDS at once."""
        # The package deletes entities in `__del__` only, whose time is not defined.
        self.condition.__del__()
        self.dds.__del__()


def parse_user_data(qos: Any) -> dict[str, str]:
    """Return the items of `key=value;…` in the USER_DATA of a discovered quality of service."""
    from cyclonedds.core import Policy

    data = qos[Policy.Userdata].data if Policy.Userdata in qos else b""
    items = (item.partition("=") for item in data.decode("utf-8", "replace").split(";"))
    return {key: value for key, separator, value in items if separator}


def _matched(read: Callable[[], list[int]]) -> list[int]:
    """Return the handles of matched endpoints.

    The package asks for their number first, and raises an IndexError if there is one more by then.
    """
    while True:
        try:
            return [_unsigned(handle) for handle in read()]
        except IndexError:
            continue


def _user_data(handles: list[int], discovery_data: Any) -> dict[int, dict[str, str]]:
    found = ((handle, discovery_data(handle)) for handle in handles)
    return {handle: parse_user_data(one.qos) for handle, one in found if one is not None}


def _unsigned(handle: int) -> int:
    """Return a handle as samples and headers carry it; some functions of the package sign it."""
    return handle & 0xFFFF_FFFF_FFFF_FFFF
