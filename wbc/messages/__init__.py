"""Messages: a class for every ROS 2 message type, without ROS (extras `log` and `ros2`).

The definitions are those of the package `rosbags`. `message_type` returns message classes, which
serialize to CDR; `message_layout` locates the numbers of a serialized message, to write or read
many of them at once.
"""

from wbc.messages.layout import message_layout
from wbc.messages.message import Message, MessageError, message_type
from wbc.messages.type_description import type_description
from wbc.messages.typestore import typestore

__all__ = [
    "Message",
    "MessageError",
    "message_layout",
    "message_type",
    "type_description",
    "typestore",
]
