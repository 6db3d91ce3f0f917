"""DDS domain and network interface: the loopback interface unless configured otherwise."""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest
from rostools import ROOT, TIMEOUT, environment

from wbc.errors import MissingExtra
from wbc.ros import DiscoveryRange, Network, Node, RosError

pytest.importorskip("cyclonedds")


def parsed(network: Network) -> ET.Element:
    return ET.fromstring(network.xml())


def text(network: Network, path: str) -> str | None:
    return parsed(network).findtext(f"Domain/{path}")


def peers(network: Network) -> list[str | None]:
    return [p.get("address") for p in parsed(network).findall("Domain/Discovery/Peers/Peer")]


def interfaces(network: Network) -> list[dict[str, str]]:
    found = parsed(network).findall("Domain/General/Interfaces/NetworkInterface")
    return [dict(one.attrib) for one in found]


def test_default_is_the_loopback_interface():
    network = Network.from_environment(environment={})
    assert network.domain_id == 0
    assert interfaces(network) == [{"address": "127.0.0.1"}]
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


@pytest.mark.parametrize(
    "variables",
    [
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        {"ROS_LOCALHOST_ONLY": "1"},
        {"ROS_STATIC_PEERS": "127.0.0.1"},
    ],
)
def test_localhost_is_the_loopback_interface_where_nodes_of_ros_announce_themselves(variables):
    network = Network.from_environment(environment=variables)
    assert interfaces(network) == [{"address": "127.0.0.1"}]
    assert text(network, "Discovery/ParticipantIndex") == "auto"
    assert text(network, "Discovery/MaxAutoParticipantIndex") == "32"


def test_subnet_includes_the_loopback_interface():
    network = Network.from_environment(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"})
    assert {"address": "127.0.0.1"} in interfaces(network)
    assert text(network, "General/AllowMulticast") is None
    assert peers(network) == ["127.0.0.1"]


def test_static_peers_are_added():
    network = Network.from_environment(environment={"ROS_STATIC_PEERS": "192.0.2.7;192.0.2.8"})
    assert peers(network) == ["127.0.0.1", "192.0.2.7", "192.0.2.8"]


def test_interface_argument_overrides_the_variables():
    network = Network.from_environment(interface="eth7", environment={"ROS_LOCALHOST_ONLY": "1"})
    assert interfaces(network) == [{"name": "eth7"}]
    assert text(network, "General/AllowMulticast") is None
    by_address = Network.from_environment(interface="192.0.2.2", environment={})
    assert interfaces(by_address) == [{"address": "192.0.2.2"}]
    for name in ("lo", "127.0.0.1", "localhost"):
        assert Network.from_environment(interface=name, environment={}) == Network()


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


#: A second interface, which the nodes of ROS select by default.
ETHERNET = (
    "ip link add ethernet0 type veth peer name ethernet1",
    "ip address add 10.77.0.1/24 dev ethernet0",
    "ip link set ethernet0 up",
    "ip link set ethernet1 up",
)


def meetings(*commands: str) -> set[str]:
    """Return the combinations of settings that meet; the commands make interfaces."""
    namespace = ["unshare", "--user", "--map-root-user", "--net", "bash", "-ec"]
    setup = "\n".join(("ip link set lo up", *commands))
    try:
        subprocess.run([*namespace, setup], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"a network namespace with two interfaces cannot be made: {error}")
    script = ROOT / "tests" / "tools" / "rosmeeting.py"
    done = subprocess.run(
        [*namespace, f"{setup}\nexec '{sys.executable}' '{script}'"],
        capture_output=True,
        text=True,
        env=environment(0),
        timeout=3.0 * TIMEOUT,
    )
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout))


def test_nodes_meet_nodes_of_ros_on_a_machine_with_two_interfaces():
    assert meetings(*ETHERNET) == {
        "this machine | LOCALHOST",
        "remote peer | LOCALHOST",
        "SUBNET | LOCALHOST",
        "SUBNET | SUBNET",
    }


@pytest.mark.slow
def test_nodes_meet_nodes_of_ros_on_a_machine_with_the_loopback_interface_only():
    assert len(meetings()) >= 4


def test_missing_interface_is_reported():
    with pytest.raises(RosError, match="cannot be joined"):
        Network(102, DiscoveryRange.SUBNET, "no_such_interface").join()


def test_domain_cannot_be_joined_with_two_configurations():
    Network(101).join()
    with pytest.raises(RosError, match="another configuration"):
        Network(101, peers=("192.0.2.7",)).join()


def test_error_without_cyclonedds_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    with pytest.raises(MissingExtra, match=r"pip install 'wbc\[ros2\]'"):
        Node("node")


def test_wbc_ros_loads_no_middleware_before_it_is_needed():
    code = "import sys, wbc; wbc.ros.Network.from_environment(); print('cyclonedds' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
