"""Names of nodes, topics and services in ROS 2, and the DDS names they map to.

Source: ROS 2 design, "Topic and Service name mapping to DDS".
"""

from __future__ import annotations

import re

from wbc.ros.errors import InvalidName

TOPIC, REQUEST, REPLY = "rt", "rq", "rr"
_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_MAX_LENGTH = 240  # characters
_TYPE = re.compile(r"(\w+)::(msg|srv|action)::dds_::(\w+)_")
_SERVICE_PARTS = ("_Request", "_Response")


def validate_node_name(name: str) -> str:
    """Return the name of a node if it is valid.

    Raises:
        InvalidName: it contains characters that the name of a node may not have.
    """
    if not _TOKEN.fullmatch(name):
        raise InvalidName(
            f"'{name}' is not a valid node name; use letters, digits and underscores, and do not "
            "begin with a digit"
        )
    return name


def normalize_namespace(name: str) -> str:
    """Return a namespace with a leading slash and without a trailing one.

    Raises:
        InvalidName: it contains characters that a namespace may not have.
    """
    return _validated("/" + name.strip("/"), "namespace")


def resolve_name(name: str, node: str, namespace: str = "/") -> str:
    """Return the fully qualified name of a topic or service.

    Args:
        name: absolute (`/x`), relative (`x`, in the namespace) or private (`~/x`, below the node).
        node: name of the node.
        namespace: namespace of the node.

    Raises:
        InvalidName: it contains characters that the name of a topic may not have.
    """
    namespace = namespace.rstrip("/")
    if name.startswith("/"):
        full = name
    elif name == "~" or name.startswith("~/"):
        full = f"{namespace}/{node}{name[1:]}"
    else:
        full = f"{namespace}/{name}"
    return _validated(full, "topic or service")


def _validated(name: str, what: str) -> str:
    if name == "/" and what == "namespace":
        return name
    for part in name[1:].split("/"):
        if not _TOKEN.fullmatch(part) or "__" in part:
            raise InvalidName(
                f"'{name}' is not a valid {what} name: '{part}' must consist of letters, digits "
                "and single underscores, and must not begin with a digit"
            )
    if len(name) > _MAX_LENGTH:
        raise InvalidName(
            f"'{name[:40]}…' has {len(name)} characters; at most {_MAX_LENGTH} are allowed"
        )
    return name


def dds_topic_name(prefix: str, name: str) -> str:
    """Return the DDS name of a topic (prefix `TOPIC`), request or reply with a ROS name."""
    return prefix + name + {TOPIC: "", REQUEST: "Request", REPLY: "Reply"}[prefix]


def parse_dds_topic_name(name: str) -> tuple[str, str] | None:
    """Return prefix and ROS name of a DDS topic; None if it is not a topic of ROS."""
    for prefix, suffix in ((TOPIC, ""), (REQUEST, "Request"), (REPLY, "Reply")):
        if name.startswith(prefix + "/") and name.endswith(suffix):
            return prefix, name[len(prefix) : len(name) - len(suffix)]
    return None


def ros_type_name(name: str) -> str:
    """Return `pkg/msg/Name` for a DDS type of ROS; any other name unchanged."""
    match = _TYPE.fullmatch(name)
    return "/".join(match.groups()) if match else name


def service_type_name(name: str) -> str:
    """Return `pkg/srv/Name` for the type of its request or response."""
    for part in _SERVICE_PARTS:
        name = name.removesuffix(part)
    return name


def action_of(service: str, type_name: str) -> tuple[str, str] | None:
    """Return name and type of the action whose goals a service takes; None if it takes none."""
    suffix, type_suffix = "/_action/send_goal", "_SendGoal"
    if not service.endswith(suffix):
        return None
    return service.removesuffix(suffix), type_name.removesuffix(type_suffix)


def is_hidden(name: str) -> bool:
    """Return whether listings omit a name by default: one part begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
