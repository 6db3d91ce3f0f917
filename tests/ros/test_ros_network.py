"""Where a node looks for others: on the loopback interface, unless it is told otherwise."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest

from wbc.errors import MissingExtra
from wbc.ros import DiscoveryRange, Network, Node, RosError

pytest.importorskip("cyclonedds")


def parsed(network: Network) -> ET.Element:
    return ET.fromstring(network.xml())


def text(network: Network, path: str) -> str | None:
    return parsed(network).findtext(f"Domain/{path}")


def peers(network: Network) -> list[str | None]:
    return [p.get("address") for p in parsed(network).findall("Domain/Discovery/Peers/Peer")]


def interface(network: Network) -> dict[str, str]:
    found = parsed(network).find("Domain/General/Interfaces/NetworkInterface")
    return {} if found is None else dict(found.attrib)


def test_without_a_word_it_keeps_to_the_loopback_interface():
    network = Network.from_environment(environment={})
    assert network.domain_id == 0
    assert interface(network) == {"address": "127.0.0.1"}
    assert text(network, "General/AllowMulticast") == "false"
    assert peers(network) == ["127.0.0.1"]


def test_the_domain_is_that_of_the_option_or_of_the_variable():
    assert Network.from_environment(environment={"ROS_DOMAIN_ID": "42"}).domain_id == 42
    assert Network.from_environment(7, environment={"ROS_DOMAIN_ID": "42"}).domain_id == 7


@pytest.mark.parametrize("bad", ["-1", "233", "x", "1.5"])
def test_a_domain_that_cannot_be_is_refused(bad):
    with pytest.raises(RosError, match=r"0 to 232"):
        Network.from_environment(environment={"ROS_DOMAIN_ID": bad})


@pytest.mark.parametrize(
    ("variables", "reach"),
    [
        ({"ROS_LOCALHOST_ONLY": "1"}, DiscoveryRange.LOCALHOST),
        ({"ROS_LOCALHOST_ONLY": "0"}, DiscoveryRange.SUBNET),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, DiscoveryRange.LOCALHOST),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, DiscoveryRange.SUBNET),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, DiscoveryRange.OFF),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT"}, DiscoveryRange.SYSTEM_DEFAULT),
        ({"CYCLONEDDS_URI": "<CycloneDDS/>"}, DiscoveryRange.SYSTEM_DEFAULT),
        ({"ROS_STATIC_PEERS": "192.0.2.7"}, DiscoveryRange.LOCALHOST),
    ],
)
def test_the_variables_of_ros_say_how_far(variables, reach):
    assert Network.from_environment(environment=variables).discovery_range is reach


def test_a_range_that_ros_does_not_know_is_refused():
    with pytest.raises(RosError, match="SYSTEM_DEFAULT"):
        Network.from_environment(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "EVERYWHERE"})


def test_the_localhost_of_ros_is_configured_as_rmw_cyclonedds_does_it():
    network = Network.from_environment(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
    assert interface(network) == {}
    assert text(network, "General/AllowMulticast") == "false"
    assert text(network, "Discovery/ParticipantIndex") == "auto"
    assert text(network, "Discovery/MaxAutoParticipantIndex") == "32"
    assert peers(network) == ["127.0.0.1"]


def test_static_peers_are_looked_at_besides():
    network = Network.from_environment(environment={"ROS_STATIC_PEERS": "192.0.2.7;192.0.2.8"})
    assert peers(network) == ["127.0.0.1", "192.0.2.7", "192.0.2.8"]


def test_an_interface_goes_before_every_variable():
    network = Network.from_environment(interface="eth7", environment={"ROS_LOCALHOST_ONLY": "1"})
    assert interface(network) == {"name": "eth7"}
    assert text(network, "General/AllowMulticast") is None
    assert interface(Network.from_environment(interface="192.0.2.2", environment={})) == {
        "address": "192.0.2.2"
    }
    assert (
        Network.from_environment(interface="lo", environment={}).discovery_range
        is DiscoveryRange.LOOPBACK
    )


def test_nobody_is_looked_for_when_discovery_is_off():
    network = Network.from_environment(
        environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_STATIC_PEERS": "192.0.2.7"}
    )
    assert peers(network) == []
    assert text(network, "Discovery/Tag")


def test_cyclones_own_variable_has_the_last_word():
    own = "<CycloneDDS><Domain><Discovery><Tag>x</Tag></Discovery></Domain></CycloneDDS>"
    assert Network.from_environment(environment={"CYCLONEDDS_URI": own}).xml() == own
    both = {"CYCLONEDDS_URI": own, "ROS_LOCALHOST_ONLY": "1"}
    assert Network.from_environment(environment=both).xml().endswith(f",{own}")


def test_an_interface_that_is_not_there_is_told():
    with pytest.raises(RosError, match="cannot be joined"):
        Network(102, DiscoveryRange.SUBNET, "no_such_interface").join()


def test_a_process_joins_a_domain_in_one_way_only():
    Network(101).join()
    with pytest.raises(RosError, match="another configuration"):
        Network(101, DiscoveryRange.LOCALHOST).join()


def test_without_cyclonedds_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    with pytest.raises(MissingExtra, match=r"pip install 'wbc\[ros2\]'"):
        Node("lonely")


def test_wbc_ros_loads_no_middleware_before_it_is_needed():
    code = "import sys, wbc; wbc.ros.Network.from_environment(); print('cyclonedds' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
