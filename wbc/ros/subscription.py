"""Subscriptions, to messages of a known type or to the bytes of any type."""

from __future__ import annotations

import inspect
import logging
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, MessageError
from wbc.ros.dds_endpoints import DdsReader, MessageInfo, message_class
from wbc.ros.dds_types import dds_type, raw_dds_type
from wbc.ros.errors import RosError
from wbc.ros.qos import QoSProfile

if TYPE_CHECKING:
    from wbc.ros.participant import Participant

logger = logging.getLogger(__name__)

_WARNING_PERIOD = 5.0  # s between two warnings about invalid messages of one topic


class Subscription:
    """Passes the messages of one topic to a function; created by `Node.create_subscription`.

    Attributes:
        topic_name: fully qualified name of the topic.
        msg_type: class of the messages.
        qos_profile: quality of service.
        invalid_count: number of messages that could not be decoded and were skipped.
        reader: the DDS reader.
    """

    has_pending = False

    def __init__(
        self,
        participant: Participant,
        msg_type: str | type[Message],
        topic_name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
    ) -> None:
        self.topic_name, self.qos_profile = topic_name, qos_profile
        self.msg_type = message_class(msg_type)
        self._callback = _with_info(callback)
        self.invalid_count = 0
        self._next_warning = 0.0
        self.reader = DdsReader(
            participant,
            f"rt{topic_name}",
            dds_type(self.msg_type.type_name),
            qos_profile,
            f"typehash={self.msg_type.type_hash()};",
        )

    def execute(self) -> None:
        """Pass on the received messages; those that cannot be decoded are counted and skipped."""
        for data, info in self.reader.take():
            try:
                message = self.msg_type.decode(data)
            except MessageError as error:
                self._warn(error)
                continue
            self._callback(message, info)

    def _warn(self, error: MessageError) -> None:
        self.invalid_count += 1
        now = time.monotonic()
        if now >= self._next_warning:
            self._next_warning = now + _WARNING_PERIOD
            logger.warning("%s: skipped a message: %s", self.topic_name, error)

    def get_publisher_count(self) -> int:
        """Return the number of matched publishers."""
        return len(self.reader.matched)

    def __repr__(self) -> str:
        return f"Subscription({self.msg_type.type_name} on {self.topic_name}: {self.qos_profile})"


class RawSubscription:
    """Passes the bytes of one topic to a function; created by `Node.create_raw_subscription`.

    Attributes:
        topic_name: fully qualified name of the topic.
        qos_profile: quality of service.
        reader: the DDS reader.
    """

    has_pending = False

    def __init__(
        self,
        participant: Participant,
        dds_type_name: str,
        topic_name: str,
        callback: Callable[..., object],
        qos_profile: QoSProfile,
    ) -> None:
        self.topic_name, self.qos_profile = topic_name, qos_profile
        self._callback = _with_info(callback)
        self.reader = DdsReader(
            participant, f"rt{topic_name}", raw_dds_type(dds_type_name), qos_profile, ""
        )

    def execute(self) -> None:
        """Pass on the received bytes."""
        for data, info in self.reader.take():
            self._callback(data, info)


def _with_info(callback: Callable[..., object]) -> Callable[[Any, MessageInfo], object]:
    """Return a callback of message and metadata from one that takes one or two arguments.

    As in `rclpy`, a callback that can be called with the message alone gets the message alone.

    Raises:
        RosError: the callback takes neither one nor two arguments.
    """
    signature = inspect.signature(callback)
    try:
        signature.bind(None)
    except TypeError:
        try:
            signature.bind(None, None)
        except TypeError:
            raise RosError(
                f"the callback {callback!r} must take a message, or a message and its MessageInfo"
            ) from None
        return callback
    return lambda message, _: callback(message)
