"""`/rosout`: what a node has to say, for whoever listens to all nodes."""

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
from wbc.ros.stamp import stamp_at

_LOG = message_type("rcl_interfaces/msg/Log")


class Rosout(logging.Handler):
    """Publishes records of Python's `logging` as `rcl_interfaces/msg/Log`.

    Levels are the same numbers in both: 10 debug to 50 fatal. Reliable, transient local, the last
    1000 messages for 10 s, as `rclcpp` has it: who comes late still gets the latest.

    Args:
        node: that speaks.
    """

    def __init__(self, node: Node) -> None:
        super().__init__()
        self._name = node.full_name.strip("/").replace("/", ".")
        self._publisher = node.publisher(_LOG.type_name, "/rosout", ROSOUT)

    def emit(self, record: logging.LogRecord) -> None:
        """Publish a record; see `logging.Handler`."""
        try:
            message: Any = _LOG(
                level=max(0, min(record.levelno, 255)),
                name=self._name,
                msg=record.getMessage(),
                file=Path(record.pathname).name,
                function=record.funcName or "",
                line=record.lineno,
            )
            message.stamp = stamp_at(record.created)
            self._publisher.publish(message)
        except RosError:  # it has left the graph
            self.handleError(record)


@contextlib.contextmanager
def speaking(node: Node) -> Iterator[None]:
    """While it lasts, a node says what the library logs in this process; warnings also here."""
    console = logging.StreamHandler()
    console.setLevel(logging.WARNING)
    console.setFormatter(logging.Formatter(f"[%(levelname)s] [{node.name}]: %(message)s"))
    ours, handlers = logging.getLogger("wbc"), (console, Rosout(node))
    level = ours.level
    ours.setLevel(logging.INFO)
    for handler in handlers:
        ours.addHandler(handler)
    try:
        yield
    finally:
        for handler in handlers:
            ours.removeHandler(handler)
        ours.setLevel(level)
