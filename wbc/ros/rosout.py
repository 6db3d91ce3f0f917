"""`/rosout`: the log of a node, published for all nodes."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wbc.messages import message_type
from wbc.ros.errors import RosError
from wbc.ros.node import Node
from wbc.ros.qos import ROSOUT
from wbc.ros.stamp import stamp_from_seconds

_LOG = message_type("rcl_interfaces/msg/Log")


class RosoutHandler(logging.Handler):
    """Publishes records of Python's `logging` as `rcl_interfaces/msg/Log`.

    The levels have the same numbers in both, from 10 (debug) to 50 (fatal). As with `rclcpp`, the
    topic is reliable and transient local and keeps the last 1000 messages for 10 s.

    Args:
        node: the node that logs.
    """

    def __init__(self, node: Node) -> None:
        super().__init__()
        self._name = node.fully_qualified_name.strip("/").replace("/", ".")
        self._publisher = node.create_publisher(_LOG, "/rosout", ROSOUT)

    def emit(self, record: logging.LogRecord) -> None:
        """Publish a record; see `logging.Handler.emit`."""
        try:
            message: Any = _LOG(
                level=max(0, min(record.levelno, 255)),
                name=self._name,
                msg=record.getMessage(),
                file=Path(record.pathname).name,
                function=record.funcName or "",
                line=record.lineno,
            )
            message.stamp = stamp_from_seconds(record.created)
            self._publisher.publish(message)
        except RosError:  # the node has left the graph
            self.handleError(record)


@contextlib.contextmanager
def log_to_rosout(node: Node) -> Iterator[None]:
    """Publish what the library logs in this process on `/rosout`, and print its warnings."""
    console = logging.StreamHandler()
    console.setLevel(logging.WARNING)
    console.setFormatter(logging.Formatter(f"[%(levelname)s] [{node.name}]: %(message)s"))
    library, handlers = logging.getLogger("wbc"), (console, RosoutHandler(node))
    level = library.level
    library.setLevel(logging.INFO)
    for handler in handlers:
        library.addHandler(handler)
    try:
        yield
    finally:
        for handler in handlers:
            library.removeHandler(handler)
        library.setLevel(level)
