"""`wbc ros2 param`."""

from __future__ import annotations

from typing import Any

from wbc.cli.argument_types import Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.ros2.network import NetworkOptions
from wbc.ros import Node, RosError
from wbc.ros.message_yaml import parse_yaml, to_yaml
from wbc.ros.parameters import parameter_message, parameter_value


def list_parameters(
    network: NetworkOptions, *, node: str | None = None, wait: Seconds = 5.0
) -> None:
    """List the parameters of all nodes, or of one.

    Args:
        network: the network.
        node: list the parameters of this node only, e.g. /wbc.
        wait: time to wait for the response of a node, s.
    """
    with network.introspection_node() as own:
        services = own.graph.settle().services()
        suffix = "/list_parameters"
        nodes = [name.removesuffix(suffix) for name in services if name.endswith(suffix)]
        if node is not None:
            nodes = [_node_name(node)]
        for name in nodes:
            print(f"{name}:")
            for parameter in sorted(_call(own, name, "ListParameters", wait).result.names):
                print(f"  {parameter}")


def get_parameter(node: str, name: str, network: NetworkOptions, *, wait: Seconds = 5.0) -> None:
    """Print the value of a parameter.

    Args:
        node: e.g. /wbc.
        name: name of the parameter.
        network: the network.
        wait: time to wait for the response, s.
    """
    with network.introspection_node() as own:
        (value,) = _call(own, _node_name(node), "GetParameters", wait, names=[name]).values
    found = parameter_value(value)
    if found is None:
        raise RosError(f"{_node_name(node)} has no parameter '{name}'")
    print(to_yaml(found))


def set_parameter(
    node: str, name: str, value: str, network: NetworkOptions, *, wait: Seconds = 5.0
) -> ExitCode:
    """Set a parameter.

    Args:
        node: e.g. /wbc.
        name: name of the parameter.
        value: new value, as YAML, e.g. 0.5 or "[0.0, 20.0, 0.0]".
        network: the network.
        wait: time to wait for the response, s.
    """
    parameter = parameter_message(name, parse_yaml(value))
    with network.introspection_node() as own:
        response = _call(own, _node_name(node), "SetParameters", wait, parameters=[parameter])
    (result,) = response.results
    print("set" if result.successful else f"refused: {result.reason}")
    return ExitCode.SUCCESS if result.successful else ExitCode.FAILED


def _node_name(name: str) -> str:
    return "/" + name.lstrip("/")


def _call(own: Node, node: str, service: str, wait: float, **fields: Any) -> Any:
    """Call a parameter service of a node."""
    names = {"ListParameters": "list", "GetParameters": "get", "SetParameters": "set"}
    client = own.create_client(
        f"rcl_interfaces/srv/{service}", f"{node}/{names[service]}_parameters"
    )
    return client.call(client.request_type(**fields), wait)
