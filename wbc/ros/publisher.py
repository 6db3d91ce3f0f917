"""Publishers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wbc.messages import Message
from wbc.ros.dds_endpoints import DdsWriter, message_class
from wbc.ros.dds_types import dds_type
from wbc.ros.errors import RosError
from wbc.ros.qos import QoSProfile

if TYPE_CHECKING:
    from wbc.ros.participant import Participant


class Publisher:
    """Publishes messages of one type on one topic; created by `Node.create_publisher`.

    Attributes:
        topic_name: fully qualified name of the topic.
        msg_type: class of the messages.
        qos_profile: quality of service.
        writer: the DDS writer.
    """

    def __init__(
        self,
        participant: Participant,
        msg_type: str | type[Message],
        topic_name: str,
        qos_profile: QoSProfile,
    ) -> None:
        self.topic_name, self.qos_profile = topic_name, qos_profile
        self.msg_type = message_class(msg_type)
        self.writer = DdsWriter(
            participant,
            f"rt{topic_name}",
            dds_type(self.msg_type.type_name),
            qos_profile,
            f"typehash={self.msg_type.type_hash()};",
        )

    def publish(self, msg: Message | bytes | memoryview) -> None:
        """Send a message.

        Args:
            msg: a message, or the bytes of one, CDR header included, such as
                `MessageTemplate.data`.

        Raises:
            MessageError: a value does not fit its field.
            RosError: the message is of another type.
        """
        if isinstance(msg, Message):
            if msg.type_name != self.msg_type.type_name:
                raise RosError(
                    f"{self.topic_name} carries {self.msg_type.type_name}, not {msg.type_name}"
                )
            msg = msg.encode()
        self.writer.write(msg)

    def get_subscription_count(self) -> int:
        """Return the number of matched subscriptions."""
        return len(self.writer.matched)

    def __repr__(self) -> str:
        return f"Publisher({self.msg_type.type_name} on {self.topic_name}: {self.qos_profile})"
