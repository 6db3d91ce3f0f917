"""The robot's state as messages: laid out once, filled in place."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.messages import Message, Template, message_type
from wbc.robot import Robot
from wbc.ros.bridge.layout import Sample
from wbc.ros.names import to_name_token
from wbc.ros.node import Node
from wbc.ros.publisher import Publisher
from wbc.ros.qos import HIGH_RATE

WORLD = "odom"  #: the frame in which the robot's estimator tells where it is


def base_frame(robot: Robot) -> str:
    """Name of the frame that moves with the robot's base."""
    return robot.base


class Filled:
    """A topic whose message is laid out once.

    Args:
        node: through which.
        topic: its name.
        message: as it is at first.
    """

    def __init__(self, node: Node, topic: str, message: Message) -> None:
        self._publisher: Publisher = node.create_publisher(message.type_name, topic, HIGH_RATE)
        self.template = Template(message)

    def view(self, path: str) -> np.ndarray:
        """The numbers of a field, to be written into."""
        return self.template.view(path)

    def publish(self, stamp: float) -> None:
        """Send it as it is now, with a time, s since 1970."""
        self.template.stamp(stamp)
        self._publisher.publish(self.template.data)


class JointStates:
    """`joint_states`: position, velocity and commanded effort of all joints."""

    def __init__(self, node: Node, robot: Robot) -> None:
        message = message_type("sensor_msgs/msg/JointState")(
            name=list(robot.joint_names),
            position=np.zeros(robot.na),
            velocity=np.zeros(robot.na),
            effort=np.zeros(robot.na),
        )
        message.header.frame_id = base_frame(robot)
        self._topic = Filled(node, "joint_states", message)
        self._position = self._topic.view("position")
        self._velocity = self._topic.view("velocity")
        self._effort = self._topic.view("effort")

    def publish(self, sample: Sample) -> None:
        """Send a tick's."""
        self._position[:] = sample.q[7:]
        self._velocity[:] = sample.v[6:]
        self._effort[:] = sample.tau
        self._topic.publish(sample.stamp)


class Odometry:
    """`odom`: where the base is and how it moves, as the estimator has it."""

    def __init__(self, node: Node, robot: Robot) -> None:
        message = message_type("nav_msgs/msg/Odometry")()
        message.header.frame_id = WORLD
        message.child_frame_id = base_frame(robot)
        self._topic = Filled(node, "odom", message)
        self._pose = self._topic.view("pose.pose")
        self._twist = self._topic.view("twist.twist")

    def publish(self, sample: Sample) -> None:
        """Send a tick's. Pinocchio's base velocity is in base axes, as ROS has it here."""
        self._pose[:] = sample.q[:7]
        self._twist[:] = sample.v[:6]
        self._topic.publish(sample.stamp)


class BalanceTopics:
    """`balance/com`, `dcm`, `dcm_reference` and `zmp` as points, and `sensors/wrench/<sole>`.

    The names are those of the log, so that one layout shows both.
    """

    _POINTS = ("com", "dcm", "dcm_reference", "zmp")

    def __init__(self, node: Node, robot: Robot) -> None:
        point = message_type("geometry_msgs/msg/PointStamped")
        wrench = message_type("geometry_msgs/msg/WrenchStamped")
        self._points: list[tuple[str, Filled, np.ndarray]] = []
        for name in self._POINTS:
            message: Any = point()
            message.header.frame_id = WORLD
            topic = Filled(node, f"balance/{name}", message)
            self._points.append((name, topic, topic.view("point")))
        self._wrenches: list[tuple[Filled, np.ndarray]] = []
        for sole in robot.soles:
            message = wrench()
            message.header.frame_id = sole.name
            topic = Filled(node, f"sensors/wrench/{to_name_token(sole.name)}", message)
            self._wrenches.append((topic, topic.view("wrench")))

    def publish(self, sample: Sample) -> None:
        """Send a tick's; what is not known is not sent."""
        for name, topic, view in self._points:
            view[:] = getattr(sample, name)
            if not np.isnan(view[0]):
                topic.publish(sample.stamp)
        for (topic, view), wrench in zip(self._wrenches, sample.wrenches, strict=True):
            view[:] = wrench
            if not np.isnan(view[0]):
                topic.publish(sample.stamp)
