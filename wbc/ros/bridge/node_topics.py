"""Topics of the robot's node that are not quantities of the tick.

To add a topic, write a function that fills its message and declare the topic in `TOPICS`, or pass
the topic to `Bridge(topics=[...])`, which needs no change of the library. A quantity of the tick
becomes a topic by its declaration in `wbc.runtime.quantities`.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from wbc.geometry.polygon import convex_hull
from wbc.kinematics import Kinematics
from wbc.messages import message_type
from wbc.robot import Robot
from wbc.ros.errors import RosError
from wbc.ros.node import Node
from wbc.ros.qos import LATCHED, QoSProfile
from wbc.ros.stamp import stamp_from_seconds, stamp_now
from wbc.ros.topics import Publisher

logger = logging.getLogger(__name__)

_POINT = message_type("geometry_msgs/msg/Point32")

#: Fills a message, given the robot and the latest tick (None before the first one).
FillMessage = Callable[[Any, Robot, Any], None]


@dataclass(frozen=True)
class NodeTopic:
    """A topic of the robot's node.

    Attributes:
        name: absolute, relative or private name.
        msg_type: name of the message type, `pkg/msg/Name`.
        fill: called with a new message, the robot and the latest tick before each publication;
            the stamp of a header is already set. It runs in the node's process, so it must be
            defined at the top level of an importable module.
        rate: rate of publication, Hz of wall time; None to publish once.
        qos_profile: quality of service; by default late subscribers get the last message.
    """

    name: str
    msg_type: str
    fill: FillMessage
    rate: float | None = None
    qos_profile: QoSProfile = LATCHED

    def __post_init__(self) -> None:
        if self.rate is not None and not self.rate > 0.0:
            raise RosError(f"topic '{self.name}': rate is {self.rate} Hz; it must be positive")

    def check_importable(self) -> None:
        """Check that the node's process can import `fill`.

        Raises:
            RosError: `fill` is not defined at the top level of an importable module.
        """
        module = getattr(self.fill, "__module__", "__main__")
        name = getattr(self.fill, "__qualname__", "<lambda>")
        if module == "__main__" or "<" in name:
            raise RosError(
                f"topic '{self.name}': another process cannot import {module}.{name}; define it at "
                "the top level of a module of its own"
            )


class NodeTopics:
    """Publishes topics, each once or at its rate.

    Args:
        node: node that publishes the topics.
        robot: the robot.
        topics: the topics.
        latest_tick: returns the latest tick, or None before the first one.
    """

    def __init__(
        self,
        node: Node,
        robot: Robot,
        topics: Sequence[NodeTopic],
        latest_tick: Callable[[], Any],
    ) -> None:
        self._robot, self._latest_tick = robot, latest_tick
        for topic in topics:
            publisher = node.create_publisher(topic.msg_type, topic.name, topic.qos_profile)
            if topic.rate is None:
                self._publish(topic, publisher)
            else:
                node.create_timer(1.0 / topic.rate, partial(self._publish, topic, publisher))

    def _publish(self, topic: NodeTopic, publisher: Publisher) -> None:
        tick = self._latest_tick()
        message: Any = publisher.msg_type()
        if hasattr(message, "header"):
            message.header.stamp = stamp_now() if tick is None else stamp_from_seconds(tick.stamp)
        try:
            topic.fill(message, self._robot, tick)
            publisher.publish(message)
        except Exception as error:  # one topic must not stop the node
            logger.error("topic %s: %s: %s", topic.name, type(error).__name__, error)


def fill_footprint(message: Any, robot: Robot, _: Any) -> None:
    """Fill in the convex hull of the soles of the standing robot, m, in base axes.

    Nav2's costmaps take the robot's footprint from such a topic.
    """
    kinematics = Kinematics(robot, robot.standing())
    base = kinematics.frame(robot.base)
    corners = [
        base.actInv(kinematics.frame(sole.name).act(corner))
        for sole in robot.soles
        for corner in sole.corners
    ]
    hull = convex_hull(complex(x, y) for x, y, _ in corners)
    message.points = [_POINT(x=point.real, y=point.imag) for point in hull]


TOPICS = (NodeTopic("footprint", "geometry_msgs/msg/Polygon", fill_footprint),)
