"""The ROS 2 node of a robot in a running loop, which runs in its own process."""

from wbc.ros.bridge.bridge import Bridge
from wbc.ros.bridge.node_topics import NodeTopic

__all__ = ["Bridge", "NodeTopic"]
