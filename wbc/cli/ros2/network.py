"""Options of all commands that join a ROS 2 network."""

from __future__ import annotations

import functools
import os
from dataclasses import dataclass
from typing import Annotated, ClassVar

from wbc.cli.argument_types import Argument, number, whole_number
from wbc.ros import Network, Node
from wbc.ros.names import is_hidden

Domain = Annotated[int, Argument("ID", functools.partial(whole_number, high=232))]
Rate = Annotated[float, Argument("HZ", number)]


@dataclass(frozen=True)
class NetworkOptions:
    """Without these options the environment variables of ROS 2 select the network.

    Attributes:
        domain: DDS domain (default: ROS_DOMAIN_ID, or 0).
        interface: the only network interface to use, by name or address (default: loopback).
    """

    title: ClassVar[str] = "network"

    domain: Domain | None = None
    interface: Annotated[str | None, Argument("NAME")] = None

    def network(self) -> Network:
        """Return the network that options and environment select."""
        return Network.from_environment(self.domain, self.interface)

    def introspection_node(self) -> Node:
        """Return a node that listings hide by its leading underscore, as the tools of ROS 2 do."""
        return Node(f"_wbc_ros2_{os.getpid()}", network=self.network())


def print_names(types: dict[str, str], hidden: bool) -> None:
    """Print names with their types, those with a leading underscore only if `hidden`."""
    for name, type_name in types.items():
        if hidden or not is_hidden(name):
            print(f"{name} [{type_name}]" if type_name else name)
