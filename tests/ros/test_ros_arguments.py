"""The arguments after `--ros-args`."""

from __future__ import annotations

import pytest

from wbc.ros import Network, Node, RosError
from wbc.ros.arguments import RosArguments


def test_node_name_namespace_and_parameters_are_parsed():
    line = "-r __node:=legs --remap __ns:=/lab -p state_rate:=100.0 -p use_sim_time:=true --"
    found = RosArguments.parse(line.split())
    assert found == RosArguments("legs", "/lab", {"state_rate": 100.0, "use_sim_time": True})
    assert RosArguments.parse([]) == RosArguments()


def test_topics_are_remapped_by_relative_private_and_absolute_names(domain):
    remappings = RosArguments.parse(["-r", "cmd_vel:=/teleop/cmd_vel", "-r", "~/x:=y"]).remappings
    network = Network(domain)
    with Node("legs", namespace="/lab", network=network, remappings=remappings) as node:
        for name in ("cmd_vel", "/lab/cmd_vel"):
            assert node.resolve_topic_name(name) == "/teleop/cmd_vel"
        assert node.resolve_topic_name("~/x") == "/lab/y"
        assert node.resolve_topic_name("/cmd_vel") == "/cmd_vel", "another namespace"
        subscription = node.create_subscription("std_msgs/msg/String", "cmd_vel", lambda _: None)
        assert subscription.topic_name == "/teleop/cmd_vel"


@pytest.mark.parametrize("line", ["-r", "-r /a:=", "-r __x:=b", "-p rate", "--log-level debug"])
def test_unknown_argument_is_refused(line):
    with pytest.raises(RosError, match="is not known; use -r __node:=NAME"):
        RosArguments.parse(line.split())
