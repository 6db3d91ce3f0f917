"""Names: of nodes and topics in ROS 2, and what they become in DDS.

Source: ROS 2 design, "Topic and Service name mapping to DDS".
"""

from __future__ import annotations

import re

from wbc.ros.errors import NameInvalid

TOPIC, REQUEST, REPLY = "rt", "rq", "rr"
_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_LONGEST = 240
_TYPE = re.compile(r"(\w+)::(msg|srv|action)::dds_::(\w+)_")
_SERVICE_PARTS = ("_Request", "_Response")


def node_name(name: str) -> str:
    """The name, if a node may have it.

    Raises:
        NameInvalid: it has letters that a node's name may not have.
    """
    if not _TOKEN.fullmatch(name):
        raise NameInvalid(
            f"'{name}' is no name of a node; use letters, digits and underscores, not a digit first"
        )
    return name


def namespace(name: str) -> str:
    """A namespace, with its leading slash and without a trailing one.

    Raises:
        NameInvalid: it has letters that a namespace may not have.
    """
    return _checked("/" + name.strip("/"), "namespace")


def resolve(name: str, node: str, space: str = "/") -> str:
    """The full name of a topic or service.

    Args:
        name: absolute (`/x`), relative (`x`, in the namespace) or private (`~/x`, below the node).
        node: the node's name.
        space: its namespace.

    Raises:
        NameInvalid: it has letters that a topic's name may not have.
    """
    space = space.rstrip("/")
    if name.startswith("/"):
        full = name
    elif name == "~" or name.startswith("~/"):
        full = f"{space}/{node}{name[1:]}"
    else:
        full = f"{space}/{name}"
    return _checked(full, "topic or service")


def token(text: str) -> str:
    """A text as one part of a name: what a name may not have becomes an underscore."""
    text = re.sub(r"_+", "_", re.sub(r"\W", "_", text, flags=re.ASCII))
    return f"_{text}" if not text or text[0].isdigit() else text


def _checked(name: str, what: str) -> str:
    if name == "/" and what == "namespace":
        return name
    for part in name[1:].split("/"):
        if not _TOKEN.fullmatch(part) or "__" in part:
            raise NameInvalid(
                f"'{name}' is no name of a {what}: '{part}' is not made of letters, digits and "
                "single underscores, with no digit first"
            )
    if len(name) > _LONGEST:
        raise NameInvalid(f"'{name[:40]}…' has {len(name)} letters; at most {_LONGEST} may be")
    return name


def dds_topic(kind: str, name: str) -> str:
    """What a topic, request or reply of some full name is called in DDS."""
    return kind + name + {TOPIC: "", REQUEST: "Request", REPLY: "Reply"}[kind]


def ros_topic(name: str) -> tuple[str, str] | None:
    """Kind and ROS name of a DDS topic; None when it is none of ROS."""
    for kind, suffix in ((TOPIC, ""), (REQUEST, "Request"), (REPLY, "Reply")):
        if name.startswith(kind + "/") and name.endswith(suffix):
            return kind, name[len(kind) : len(name) - len(suffix)]
    return None


def ros_type(name: str) -> str:
    """The ROS name of a DDS type, `pkg/msg/Name`; the DDS name when it is none of ROS."""
    match = _TYPE.fullmatch(name)
    return "/".join(match.groups()) if match else name


def service_type(name: str) -> str:
    """`pkg/srv/Name` of one of the two messages that it is made of."""
    for part in _SERVICE_PARTS:
        name = name.removesuffix(part)
    return name


def is_hidden(name: str) -> bool:
    """Whether listings leave a name out unless asked: a part of it starts with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
