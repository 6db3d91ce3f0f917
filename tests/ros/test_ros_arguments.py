"""The arguments after `--ros-args`."""

from __future__ import annotations

import pytest

from wbc.ros import RosError
from wbc.ros.arguments import RosArguments


def test_node_name_namespace_and_parameters_are_parsed():
    line = "-r __node:=legs --remap __ns:=/lab -p state_rate:=100.0 -p use_sim_time:=true --"
    found = RosArguments.parse(line.split())
    assert found == RosArguments("legs", "/lab", {"state_rate": 100.0, "use_sim_time": True})
    assert RosArguments.parse([]) == RosArguments()


@pytest.mark.parametrize("line", ["-r", "-r /a:=/b", "-p rate", "--log-level debug"])
def test_unknown_argument_is_refused(line):
    with pytest.raises(RosError, match="is not known; use -r __node:=NAME"):
        RosArguments.parse(line.split())
