"""DDS writers and readers of serialized messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from wbc.ros.errors import RosError
from wbc.ros.qos import QoSProfile

_BATCH = 256  # samples taken at once


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
        topic: DDS name of the topic.
        sample_type: class of the samples, see `wbc.ros.dds_types`.
        qos_profile: quality of service.
        user_data: USER_DATA of the endpoint, visible to others at discovery.

    Attributes:
        dds: the data writer of Cyclone DDS.
        handle: instance handle, as samples carry it.
        gid: 16-byte id.
    """

    def __init__(
        self,
        participant: Any,
        topic: str,
        sample_type: Any,
        qos_profile: QoSProfile,
        user_data: str,
    ) -> None:
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic

        self._sample = sample_type()
        self.dds = DataWriter(
            participant, Topic(participant, topic, sample_type), qos=qos_profile.to_dds(user_data)
        )
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
        return [_unsigned(handle) for handle in self.dds.get_matched_subscriptions()]

    def matched_user_data(self, handle: int) -> dict[str, str] | None:
        """Return the USER_DATA of a matched reader; None if it has left."""
        return _user_data(self.dds.get_matched_subscription_data(handle))


class DdsReader:
    """Receives serialized messages from a DDS topic; see `DdsWriter` for the arguments.

    Attributes:
        dds: the data reader of Cyclone DDS.
        gid: 16-byte id.
        condition: read condition for a wait set, true while there are samples.
    """

    def __init__(
        self,
        participant: Any,
        topic: str,
        sample_type: Any,
        qos_profile: QoSProfile,
        user_data: str,
    ) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        self.dds = DataReader(
            participant, Topic(participant, topic, sample_type), qos=qos_profile.to_dds(user_data)
        )
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
        return [_unsigned(handle) for handle in self.dds.get_matched_publications()]

    def matched_user_data(self, handle: int) -> dict[str, str] | None:
        """Return the USER_DATA of a matched writer; None if it has left."""
        return _user_data(self.dds.get_matched_publication_data(handle))

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


def _user_data(endpoint: Any) -> dict[str, str] | None:
    return None if endpoint is None else parse_user_data(endpoint.qos)


def _unsigned(handle: int) -> int:
    """Return a handle as samples and headers carry it; some functions of the package sign it."""
    return handle & 0xFFFF_FFFF_FFFF_FFFF
