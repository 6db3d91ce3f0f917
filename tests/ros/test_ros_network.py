"""DDS domain and network interface: the loopback interface unless configured otherwise."""

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


def test_default_is_the_loopback_interface():
    network = Network.from_environment(environment={})
    assert network.domain_id == 0
    assert interface(network) == {"address": "127.0.0.1"}
    assert text(network, "General/AllowMulticast") == "false"
    assert peers(network) == ["127.0.0.1"]


def test_domain_id_is_the_argument_or_the_variable():
    assert Network.from_environment(environment={"ROS_DOMAIN_ID": "42"}).domain_id == 42
    assert Network.from_environment(7, environment={"ROS_DOMAIN_ID": "42"}).domain_id == 7


@pytest.mark.parametrize("bad", ["-1", "233", "x", "1.5"])
def test_invalid_domain_id_is_refused(bad):
    with pytest.raises(RosError, match=r"0 to 232"):
        Network.from_environment(environment={"ROS_DOMAIN_ID": bad})


@pytest.mark.parametrize(
    ("variables", "discovery_range"),
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
def test_variables_of_ros_select_the_discovery_range(variables, discovery_range):
    assert Network.from_environment(environment=variables).discovery_range is discovery_range


def test_unknown_discovery_range_is_refused():
    with pytest.raises(RosError, match="SYSTEM_DEFAULT"):
        Network.from_environment(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "EVERYWHERE"})


def test_localhost_is_configured_as_in_rmw_cyclonedds():
    network = Network.from_environment(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
    assert interface(network) == {}
    assert text(network, "General/AllowMulticast") == "false"
    assert text(network, "Discovery/ParticipantIndex") == "auto"
    assert text(network, "Discovery/MaxAutoParticipantIndex") == "32"
    assert peers(network) == ["127.0.0.1"]


def test_static_peers_are_added():
    network = Network.from_environment(environment={"ROS_STATIC_PEERS": "192.0.2.7;192.0.2.8"})
    assert peers(network) == ["127.0.0.1", "192.0.2.7", "192.0.2.8"]


def test_interface_argument_overrides_the_variables():
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


def test_discovery_off_has_no_peers():
    network = Network.from_environment(
        environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_STATIC_PEERS": "192.0.2.7"}
    )
    assert peers(network) == []
    assert text(network, "Discovery/Tag")


def test_cyclonedds_uri_overrides_all_other_settings():
    own = "<CycloneDDS><Domain><Discovery><Tag>x</Tag></Discovery></Domain></CycloneDDS>"
    assert Network.from_environment(environment={"CYCLONEDDS_URI": own}).xml() == own
    both = {"CYCLONEDDS_URI": own, "ROS_LOCALHOST_ONLY": "1"}
    assert Network.from_environment(environment=both).xml().endswith(f",{own}")


def test_missing_interface_is_reported():
    with pytest.raises(RosError, match="cannot be joined"):
        Network(102, DiscoveryRange.SUBNET, "no_such_interface").join()


def test_domain_cannot_be_joined_with_two_configurations():
    Network(101).join()
    with pytest.raises(RosError, match="another configuration"):
        Network(101, DiscoveryRange.LOCALHOST).join()


def test_error_without_cyclonedds_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    with pytest.raises(MissingExtra, match=r"pip install 'wbc\[ros2\]'"):
        Node("node")


def test_wbc_ros_loads_no_middleware_before_it_is_needed():
    code = "import sys, wbc; wbc.ros.Network.from_environment(); print('cyclonedds' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
