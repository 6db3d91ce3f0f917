"""`wbc ros2 service`."""

from __future__ import annotations

from wbc.cli.argument_types import Seconds
from wbc.cli.ros2.network import NetworkOptions, print_names
from wbc.ros import ResponseTimeout
from wbc.ros.message_yaml import from_yaml, to_yaml


def list_services(network: NetworkOptions, *, all: bool = False) -> None:
    """List the services.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        print_names(node.graph.settle().services(), all)


def call(
    service: str,
    type: str,
    values: tuple[str, ...],
    network: NetworkOptions,
    *,
    wait: Seconds = 10.0,
) -> None:
    """Call a service and print the response.

    Args:
        service: e.g. /reset_robot.
        type: type of the service, e.g. std_srvs/srv/Trigger.
        values: fields of the request that are not zero, as YAML.
        network: the network.
        wait: time to wait for the response, s.
    """
    with network.introspection_node() as node:
        client = node.create_client(type, service)
        request = from_yaml(client.request_type, " ".join(values))
        try:
            response = client.call(request, wait)
        except ResponseTimeout as error:
            raise ResponseTimeout(f"{error} ({node.network.hint})") from error
    print(to_yaml(response))
