"""Publishers and subscriptions."""

from __future__ import annotations

import inspect
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError, message_type
from wbc.ros.dds_endpoints import EndpointConfig, MessageInfo
from wbc.ros.dds_types import dds_type
from wbc.ros.errors import RosError
from wbc.ros.names import TOPIC, dds_topic_name
from wbc.ros.qos import QoSProfile

if TYPE_CHECKING:
    from wbc.ros.node import Node

logger = logging.getLogger(__name__)

_WARNING_PERIOD = 5.0  # s between two warnings about invalid messages of one topic


class Publisher:
    """Publishes messages of one type on one topic; created by `Node.create_publisher`.

    Attributes:
        topic_name: fully qualified name of the topic.
        msg_type: class of the messages.
        qos_profile: quality of service.
        writer: the DDS writer.
    """

    def __init__(
        self, node: Node, msg_type: str | type[Message], topic: str, qos_profile: QoSProfile | int
    ) -> None:
        self.topic_name = node.resolve_topic_name(topic)
        self.qos_profile = QoSProfile.of(qos_profile)
        self.msg_type = _message_class(msg_type)
        config = _endpoint_config(self.topic_name, self.msg_type, self.qos_profile)
        self.writer = node.participant.create_writer(config)

    def publish(self, msg: Message | bytes | memoryview) -> None:
        """Send a message.

        Args:
            msg: a message, or the bytes of one, CDR header included, such as `Template.data`.

        Raises:
            MessageError: a value does not fit its field.
            RosError: the message is of another type.
        """
        if isinstance(msg, Message):
            given, expected = type(msg).type_name, self.msg_type.type_name
            if given != expected:
                raise RosError(f"{self.topic_name} carries {expected}, not {given}")
            msg = msg.encode()
        self.writer.write(msg)

    def get_subscription_count(self) -> int:
        """Return the number of matched subscriptions."""
        return len(self.writer.matched)

    def __repr__(self) -> str:
        return f"Publisher({self.msg_type.type_name} on {self.topic_name}: {self.qos_profile})"


class RawSubscription:
    """Passes the bytes of one topic to a function; created by `Node.create_raw_subscription`.

    Attributes:
        topic_name: fully qualified name of the topic.
        qos_profile: quality of service.
        reader: the DDS reader.
    """

    def __init__(
        self, node: Node, config: EndpointConfig, topic_name: str, callback: Callable[..., object]
    ) -> None:
        self.topic_name, self.qos_profile = topic_name, config.qos_profile
        self._callback = _with_info(callback)
        self.reader = node.participant.create_reader(config)

    def execute(self) -> None:
        """Pass on the received messages."""
        for data, info in self.reader.take():
            self._receive(data, info)

    def _receive(self, data: bytes, info: MessageInfo) -> None:
        self._callback(data, info)

    def get_publisher_count(self) -> int:
        """Return the number of matched publishers."""
        return len(self.reader.matched)


class Subscription(RawSubscription):
    """Passes the messages of one topic to a function; created by `Node.create_subscription`.

    Messages that cannot be decoded are skipped with a warning.

    Attributes:
        msg_type: class of the messages.
    """

    def __init__(
        self,
        node: Node,
        msg_type: str | type[Message],
        topic: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile | int,
        ignore_local_publications: bool = False,
    ) -> None:
        self.msg_type = _message_class(msg_type)
        self._next_warning = 0.0
        name = node.resolve_topic_name(topic)
        config = _endpoint_config(name, self.msg_type, QoSProfile.of(qos_profile))
        config = replace(config, ignore_local=ignore_local_publications)
        super().__init__(node, config, name, callback)

    def _receive(self, data: bytes, info: MessageInfo) -> None:
        try:
            message = self.msg_type.decode(data)
        except MessageError as error:
            if time.monotonic() >= self._next_warning:
                self._next_warning = time.monotonic() + _WARNING_PERIOD
                logger.warning("%s: skipped a message: %s", self.topic_name, error)
        else:
            self._callback(message, info)

    def __repr__(self) -> str:
        return f"Subscription({self.msg_type.type_name} on {self.topic_name}: {self.qos_profile})"


def _message_class(msg_type: str | type[Message]) -> type[Message]:
    return message_type(msg_type) if isinstance(msg_type, str) else msg_type


def _endpoint_config(
    topic_name: str, msg_type: type[Message], qos_profile: QoSProfile
) -> EndpointConfig:
    dds_name, sample_type = dds_topic_name(TOPIC, topic_name), dds_type(msg_type.type_name)
    return EndpointConfig(dds_name, sample_type, qos_profile, f"typehash={msg_type.type_hash()};")


def _with_info(callback: Callable[..., object]) -> Callable[[Any, MessageInfo], object]:
    """Return a callback of message and metadata from one that takes one or two arguments.

    As in `rclpy`, a callback that can be called with the message alone gets the message alone.

    Raises:
        RosError: the callback takes neither one nor two arguments.
    """
    signature = inspect.signature(callback)
    for arguments, adapted in (
        ((None,), lambda message, _: callback(message)),
        ((None, None), callback),
    ):
        try:
            signature.bind(*arguments)
        except TypeError:
            continue
        return adapted
    raise RosError(
        f"the callback {callback!r} must take a message, or a message and its MessageInfo"
    )
