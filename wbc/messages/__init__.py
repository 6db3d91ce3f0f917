"""ROS 2 messages without ROS: definitions, CDR bytes, type hashes.

Needs numpy alone. `message_type` makes classes to read and write messages with, `Template`
lays a message out once whose numbers then change at every tick.
"""

from wbc.messages.errors import MessageError
from wbc.messages.library import available, definition, schema_text
from wbc.messages.message import Message, message_type
from wbc.messages.template import Template
from wbc.messages.type_hash import service_hash, type_hash

__all__ = [
    "Message",
    "MessageError",
    "Template",
    "available",
    "definition",
    "message_type",
    "schema_text",
    "service_hash",
    "type_hash",
]
