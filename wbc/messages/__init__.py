"""ROS 2 messages without ROS: definitions, CDR serialization and type hashes.

Requires only numpy. `message_type` returns message classes; `Template` serializes a message once
and then updates its numbers in place.
"""

from wbc.messages.errors import MessageError
from wbc.messages.message import Message, message_type
from wbc.messages.registry import available_types, get_definition, schema_text
from wbc.messages.template import Template
from wbc.messages.type_hash import service_hash, type_hash

__all__ = [
    "Message",
    "MessageError",
    "Template",
    "available_types",
    "get_definition",
    "message_type",
    "schema_text",
    "service_hash",
    "type_hash",
]
