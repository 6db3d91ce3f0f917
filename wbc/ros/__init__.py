"""ROS 2 without ROS: nodes over DDS that a ROS 2 system takes for its own. Extra `ros2`."""

from wbc.ros.endpoints import Info, Publisher, Subscription
from wbc.ros.errors import NameInvalid, NoAnswer, RosError
from wbc.ros.network import Network, Reach
from wbc.ros.node import Node, Timer
from wbc.ros.parameters import Parameter, Parameters
from wbc.ros.qos import Qos
from wbc.ros.services import Client, Reply, Service

__all__ = [
    "Client",
    "Info",
    "NameInvalid",
    "Network",
    "NoAnswer",
    "Node",
    "Parameter",
    "Parameters",
    "Publisher",
    "Qos",
    "Reach",
    "Reply",
    "RosError",
    "Service",
    "Subscription",
    "Timer",
]
