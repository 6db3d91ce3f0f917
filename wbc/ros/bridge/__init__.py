"""A robot in a running loop as a node of a ROS 2 system, from a process of its own."""

from wbc.ros.bridge.bridge import Bridge
from wbc.ros.bridge.node_topics import NodeTopic

__all__ = ["Bridge", "NodeTopic"]
