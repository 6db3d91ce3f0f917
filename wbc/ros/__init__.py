"""ROS 2 nodes over DDS, without a ROS 2 installation (extra `ros2`).

The names are those of `rclpy`. Message types are passed as classes, which
`wbc.messages.message_type` returns, or by name, for example "sensor_msgs/msg/JointState".
"""

from wbc.ros.actions import ActionClient, ActionServer, GoalStatus
from wbc.ros.dds_endpoints import MessageInfo
from wbc.ros.errors import InvalidName, ResponseTimeout, RosError
from wbc.ros.executor import Timer
from wbc.ros.network import DiscoveryRange, Network
from wbc.ros.node import Node
from wbc.ros.parameters import NodeParameter
from wbc.ros.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from wbc.ros.services import Client, Service, ServiceReply
from wbc.ros.topics import Publisher, RawSubscription, Subscription

__all__ = [
    "ActionClient",
    "ActionServer",
    "Client",
    "DiscoveryRange",
    "DurabilityPolicy",
    "GoalStatus",
    "HistoryPolicy",
    "InvalidName",
    "MessageInfo",
    "Network",
    "Node",
    "NodeParameter",
    "Publisher",
    "QoSProfile",
    "RawSubscription",
    "ReliabilityPolicy",
    "ResponseTimeout",
    "RosError",
    "Service",
    "ServiceReply",
    "Subscription",
    "Timer",
]
