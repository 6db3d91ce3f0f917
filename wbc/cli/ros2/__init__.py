"""`wbc ros2`: nodes and graph introspection on a ROS 2 network, without ROS 2."""

from __future__ import annotations

from wbc.cli.parser import Command, DeferredCommand, Parser, set_commands
from wbc.cli.ros2 import actions, graph, parameters, services, topics

_RUN = "wbc.cli.ros2.run"  # imports simulator and controller

_DESCRIPTION = """\
Run ROS 2 nodes over DDS (Cyclone DDS) and inspect the ROS graph, without a ROS installation. The
verbs are those of the `ros2` command.

Nodes are met on this machine only, unless --interface or one of these environment variables
selects another network: ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_LOCALHOST_ONLY,
ROS_STATIC_PEERS, CYCLONEDDS_URI. A ROS 2 system looks for nodes in the subnet: set
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST there, or CYCLONEDDS_URI to what `wbc ros2 uri` prints.
"""

VERBS: dict[str, Command] = {
    "walk": DeferredCommand(_RUN, "walk", "simulate a robot that a ROS 2 system drives"),
    "joint-publisher": DeferredCommand(
        _RUN, "joint_publisher", "publish a pattern of fifteen joints"
    ),
    "uri": graph.uri,
    "node": {"list": graph.list_nodes, "info": graph.print_node},
    "topic": {
        "list": topics.list_topics,
        "info": topics.print_topic,
        "echo": topics.echo,
        "hz": topics.hz,
        "pub": topics.publish,
    },
    "service": {"list": services.list_services, "call": services.call},
    "param": {
        "list": parameters.list_parameters,
        "get": parameters.get_parameter,
        "set": parameters.set_parameter,
    },
    "action": {"list": actions.list_actions, "send_goal": actions.send_goal},
}


def add_verbs(parser: Parser) -> None:
    """Add the verbs."""
    parser.description = _DESCRIPTION
    set_commands(parser, VERBS)
