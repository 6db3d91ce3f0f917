"""Publishers and subscriptions: what a node writes and reads on topics."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError, message_type
from wbc.ros.errors import RosError
from wbc.ros.qos import Qos
from wbc.ros.wire import dds_type, unread_type

if TYPE_CHECKING:
    from wbc.ros.participant import Participant

logger = logging.getLogger(__name__)

_BATCH = 256  # samples taken at once
_COMPLAIN = 5.0  # s between two words about bad messages of one topic


@dataclass(frozen=True, slots=True)
class Info:
    """About one message.

    Attributes:
        sent: by its writer's clock, s since 1970.
        writer: handle of its writer in this process.
        size: of its bytes, header included.
    """

    sent: float
    writer: int
    size: int


class Writer:
    """Sends bytes on a DDS topic.

    Args:
        participant: through which.
        topic: its DDS name.
        kind: the class of its samples, see `wbc.ros.wire`.
        qos: quality of service.
        user_data: what it tells about itself at discovery.
    """

    def __init__(
        self, participant: Participant, topic: str, kind: Any, qos: Qos, user_data: str
    ) -> None:
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic

        dds = participant.dds
        self._sample = kind()
        self.dds = DataWriter(dds, Topic(dds, topic, kind), qos=qos.to_dds(user_data))
        self.handle = _unsigned(self.dds.instance_handle)
        self.gid: bytes = self.dds.guid.bytes

    def write(self, data: Any) -> None:
        """Send a message's bytes, header included.

        Raises:
            RosError: they are no message of the topic's type, or the network is gone.
        """
        from cyclonedds.core import DDSException

        self._sample.data = data  # the package fills it up with zeros to whole words
        try:
            self.dds.write(self._sample)
        except DDSException as error:
            raise RosError(f"{len(data)} bytes could not be sent: {error}") from error

    @property
    def matched(self) -> list[int]:
        """Handles of the readers that get what is written."""
        return [_unsigned(handle) for handle in self.dds.get_matched_subscriptions()]

    def peer(self, handle: int) -> Any:
        """What is known of one of the `matched`; None when it has gone."""
        return self.dds.get_matched_subscription_data(handle)


class Reader:
    """Receives bytes on a DDS topic; see `Writer`."""

    def __init__(
        self, participant: Participant, topic: str, kind: Any, qos: Qos, user_data: str
    ) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        dds = participant.dds
        self.dds = DataReader(dds, Topic(dds, topic, kind), qos=qos.to_dds(user_data))
        self.gid: bytes = self.dds.guid.bytes
        self.condition = ReadCondition(
            self.dds, SampleState.Any | ViewState.Any | InstanceState.Any
        )

    def take(self) -> list[tuple[bytes, Info]]:
        """What has come since the last call; what only tells that a writer left is dropped."""
        taken = []
        for sample in self.dds.take(_BATCH):
            about = sample.sample_info
            if about.valid_data:
                sent = 1e-9 * about.source_timestamp
                info = Info(sent, about.publication_handle, len(sample.data))
                taken.append((sample.data, info))
        return taken

    @property
    def matched(self) -> list[int]:
        """Handles of the writers that are read."""
        return [_unsigned(handle) for handle in self.dds.get_matched_publications()]

    def peer(self, handle: int) -> Any:
        """What is known of one of the `matched`; None when it has gone."""
        return self.dds.get_matched_publication_data(handle)

    def close(self) -> None:
        """Leave DDS now rather than some time, for which the package has no other way."""
        self.condition.__del__()
        self.dds.__del__()


def _unsigned(handle: int) -> int:
    """A handle as samples and headers carry it; some functions of the package give it a sign."""
    return handle & 0xFFFF_FFFF_FFFF_FFFF


class Publisher:
    """Publishes messages of one type on one topic; `Node.publisher` makes it.

    Attributes:
        topic: its full ROS name.
        type_name: `pkg/msg/Name`.
        qos: quality of service.
        writer: below it.
    """

    def __init__(self, participant: Participant, topic: str, type_name: str, qos: Qos) -> None:
        self.topic, self.qos = topic, qos
        kind = message_type(type_name)
        self.type_name = kind.type_name
        hashed = f"typehash={kind.type_hash()};"
        self.writer = Writer(participant, f"rt{topic}", dds_type(kind.type_name), qos, hashed)

    def publish(self, message: Message) -> None:
        """Send a message.

        Raises:
            MessageError: a value does not fit its field.
            RosError: it is a message of another type.
        """
        if message.type_name != self.type_name:
            raise RosError(f"{self.topic} carries {self.type_name}, not {message.type_name}")
        self.writer.write(message.encode())

    def publish_bytes(self, data: Any) -> None:
        """Send a message's bytes, header included, such as those of a `Template`.

        Raises:
            RosError: they are no message of the topic's type.
        """
        self.writer.write(data)

    @property
    def subscriptions(self) -> int:
        """How many get what is published."""
        return len(self.writer.matched)


class Subscription:
    """Hands the messages of one topic to a function; `Node.subscription` makes it.

    Attributes:
        topic: its full ROS name.
        type_name: `pkg/msg/Name`.
        bad: messages that could not be read and were skipped.
        reader: below it.
    """

    impatient = False

    def __init__(
        self,
        participant: Participant,
        topic: str,
        type_name: str,
        callback: Callable[[Any, Info], None],
        qos: Qos,
    ) -> None:
        self.topic, self.qos = topic, qos
        self._kind = message_type(type_name)
        self.type_name = self._kind.type_name
        self._callback = callback
        self.bad = 0
        self._quiet_until = 0.0
        hashed = f"typehash={self._kind.type_hash()};"
        self.reader = Reader(participant, f"rt{topic}", dds_type(self.type_name), qos, hashed)

    def work(self) -> None:
        """Hand over what has come; what is no message is counted and skipped."""
        for data, info in self.reader.take():
            try:
                message = self._kind.decode(data)
            except MessageError as error:
                self._complain(error)
                continue
            self._callback(message, info)

    def _complain(self, error: MessageError) -> None:
        self.bad += 1
        now = time.monotonic()
        if now >= self._quiet_until:
            self._quiet_until = now + _COMPLAIN
            logger.warning("%s: a message was skipped: %s", self.topic, error)

    @property
    def publishers(self) -> int:
        """How many are heard."""
        return len(self.reader.matched)


class Listener:
    """Hands the bytes of one topic to a function, whatever its type; `Node.listen` makes it.

    Attributes:
        topic: its full ROS name.
        reader: below it.
    """

    impatient = False

    def __init__(
        self,
        participant: Participant,
        topic: str,
        dds_type_name: str,
        callback: Callable[[bytes, Info], None],
        qos: Qos,
    ) -> None:
        self.topic = topic
        self._callback = callback
        self.reader = Reader(participant, f"rt{topic}", unread_type(dds_type_name), qos, "")

    def work(self) -> None:
        """Hand over what has come."""
        for data, info in self.reader.take():
            self._callback(data, info)
