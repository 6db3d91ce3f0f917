"""`wbc ros2 node` and `wbc ros2 uri`."""

from __future__ import annotations

import sys

from wbc.cli.ros2.network import NetworkOptions, print_names
from wbc.errors import did_you_mean
from wbc.ros import RosError
from wbc.ros.graph_snapshot import EndpointType, GraphSnapshot
from wbc.ros.names import REPLY, REQUEST, TOPIC, action_of, is_hidden, service_type_name


def uri(network: NetworkOptions) -> None:
    """Print the CYCLONEDDS_URI for a ROS 2 system on this network."""
    print(network.network().xml())


def list_nodes(network: NetworkOptions, *, all: bool = False) -> None:
    """List the nodes.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        nodes = node.graph.settle().nodes
        print_names(dict.fromkeys(nodes, ""), all)
        if not nodes:
            print(f"no node was met ({node.network.hint})", file=sys.stderr)


def print_node(node_name: str, network: NetworkOptions, *, all: bool = False) -> None:
    """Print the topics, services and actions of a node.

    Args:
        node_name: e.g. /wbc.
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        graph = node.graph.settle()
        hint = node.network.hint
    name = "/" + node_name.lstrip("/")
    if name not in graph.nodes:
        reason = did_you_mean(name, graph.nodes) if graph.nodes else f"; no node was met ({hint})"
        raise RosError(f"there is no node '{name}'{reason}")
    print(name)
    for title, names in _endpoints(graph, name).items():
        print(f"  {title}:")
        for topic, types in sorted(names.items()):
            if all or not is_hidden(topic):
                print(f"    {topic}: {', '.join(sorted(types))}")


def _endpoints(graph: GraphSnapshot, node: str) -> dict[str, dict[str, set[str]]]:
    """Return names and types of a node's topics, services and actions, by what they are."""
    subscription = EndpointType.SUBSCRIPTION
    titles = {
        (TOPIC, True): "Subscribers",
        (TOPIC, False): "Publishers",
        (REQUEST, True): "Service Servers",
        (REQUEST, False): "Service Clients",
    }
    found: dict[str, dict[str, set[str]]] = {title: {} for title in titles.values()}
    found |= {"Action Servers": {}, "Action Clients": {}}
    for endpoint in graph.endpoints:
        if endpoint.node != node or endpoint.prefix == REPLY:
            continue
        receives = endpoint.endpoint_type is subscription
        title = titles[endpoint.prefix, receives]
        found[title].setdefault(endpoint.topic, set()).add(service_type_name(endpoint.type_name))
        action = action_of(endpoint.topic, service_type_name(endpoint.type_name))
        if action is not None and endpoint.prefix == REQUEST:
            servers_or_clients = found["Action Servers" if receives else "Action Clients"]
            servers_or_clients[action[0]] = {action[1]}
    return found
