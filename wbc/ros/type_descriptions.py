"""The service that describes the message types of a node."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wbc.messages import MessageError, message_type, type_description

if TYPE_CHECKING:
    from wbc.ros.node import Node


def serve_type_descriptions(node: Node) -> None:
    """Offer `~/get_type_description`, by which others decode messages of types they do not have.

    Args:
        node: the node.
    """
    node.create_service(
        "type_description_interfaces/srv/GetTypeDescription",
        "~/get_type_description",
        _describe,
    )


def _describe(request: Any, response: Any) -> Any:
    try:
        known = message_type(request.type_name).type_hash()
        if request.type_hash not in ("", known):
            response.failure_reason = f"{request.type_name} has the hash {known} here"
            return response
        response.type_description = type_description(request.type_name)
        response.successful = True
    except MessageError as error:
        response.failure_reason = str(error)
    return response
