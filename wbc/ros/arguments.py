"""The arguments that follow `--ros-args`: names of node, namespace and topics, and parameters.

Source: ROS 2 documentation, "Passing ROS arguments to nodes via the command-line".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from wbc.ros.errors import RosError
from wbc.ros.message_yaml import parse_yaml

_REMAP, _PARAMETER = ("-r", "--remap"), ("-p", "--param")


@dataclass(frozen=True)
class RosArguments:
    """Parsed arguments.

    Attributes:
        name: name of the node; empty if it is not given.
        namespace: namespace of the node; empty if it is not given.
        parameters: values of parameters by their names.
        remappings: new names of topics, services and actions by their names.
    """

    name: str = ""
    namespace: str = ""
    parameters: dict[str, Any] = field(default_factory=dict)
    remappings: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def parse(arguments: Sequence[str]) -> RosArguments:
        """Return the arguments of a command line, without `--ros-args` itself.

        `-r __node:=NAME`, `-r __ns:=NAMESPACE`, `-r FROM:=TO` and `-p NAME:=VALUE` are known.

        Raises:
            RosError: an argument is not one of these.
        """
        name = namespace = ""
        parameters: dict[str, Any] = {}
        remappings: dict[str, str] = {}
        rest = [argument for argument in arguments if argument != "--"]
        for flag, text in zip(rest[::2], [*rest[1::2], ""], strict=False):
            key, assigned, value = text.partition(":=")
            if flag in _REMAP and assigned and key in ("__node", "__name"):
                name = value
            elif flag in _REMAP and assigned and key == "__ns":
                namespace = value
            elif flag in _REMAP and key and value and not key.startswith("__"):
                remappings[key] = value
            elif flag in _PARAMETER and assigned and key:
                parameters[key] = parse_yaml(value)
            else:
                raise RosError(
                    f"--ros-args: '{flag} {text}' is not known; use -r __node:=NAME, "
                    "-r __ns:=NAMESPACE, -r FROM:=TO or -p NAME:=VALUE"
                )
        return RosArguments(name, namespace, parameters, remappings)
