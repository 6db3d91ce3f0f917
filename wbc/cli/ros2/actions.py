"""`wbc ros2 action`."""

from __future__ import annotations

import math
from typing import Any

from wbc.cli.argument_types import Seconds
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import graceful_interrupt
from wbc.cli.ros2.network import NetworkOptions, print_names
from wbc.ros import ActionClient, GoalStatus
from wbc.ros.message_yaml import from_yaml, to_yaml
from wbc.ros.names import action_of

_CANCEL_TIMEOUT = 10.0  # s


def list_actions(network: NetworkOptions, *, all: bool = False) -> None:
    """List the actions.

    Args:
        network: the network.
        all: include hidden names.
    """
    with network.introspection_node() as node:
        services = node.graph.settle().services().items()
        print_names(dict(filter(None, (action_of(*service) for service in services))), all)


def send_goal(
    action: str,
    type: str,
    goal: tuple[str, ...],
    network: NetworkOptions,
    *,
    feedback: bool = False,
    wait: Seconds = 10.0,
    timeout: Seconds = math.inf,
) -> ExitCode:
    """Send a goal and wait for its result; Ctrl-C cancels it.

    Args:
        action: e.g. /navigate_to_pose.
        type: type of the action, e.g. nav2_msgs/action/NavigateToPose.
        goal: fields of the goal that are not zero, as YAML.
        network: the network.
        feedback: print the feedback.
        wait: time to wait for the server, s.
        timeout: cancel the goal after this time, s.
    """

    def show(message: Any) -> None:
        if feedback:
            print(f"feedback:\n{to_yaml(message)}\n---")

    with network.introspection_node() as node, graceful_interrupt() as interrupted:
        client = ActionClient(node, type, action)
        handle = client.send_goal(from_yaml(client.goal_type, " ".join(goal)), show, wait)
        if not handle.accepted:
            print("the goal was rejected")
            return ExitCode.FAILED
        print("the goal was accepted")
        node.spin_until(lambda: interrupted or handle.status.terminal, timeout)
        if not handle.status.terminal:
            handle.cancel_goal()
            handle.wait_for_result(_CANCEL_TIMEOUT)
    print(f"{handle.status.name.lower()}\n{to_yaml(handle.result) if handle.result else ''}")
    if interrupted:
        return ExitCode.INTERRUPTED
    return ExitCode.SUCCESS if handle.status is GoalStatus.SUCCEEDED else ExitCode.FAILED
