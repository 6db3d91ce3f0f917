"""Names of ROS 2, and the DDS names that they map to."""

from __future__ import annotations

import pytest

from wbc.ros import InvalidName, names


@pytest.mark.parametrize(
    ("name", "full"),
    [
        ("joint_states", "/robot/joint_states"),
        ("/joint_states", "/joint_states"),
        ("~/get_parameters", "/robot/legs/get_parameters"),
        ("~", "/robot/legs"),
        ("arm/wrench", "/robot/arm/wrench"),
    ],
)
def test_names_are_resolved_as_in_ros(name, full):
    assert names.resolve_name(name, "legs", "/robot") == full


def test_root_namespace_adds_no_prefix():
    assert names.resolve_name("chatter", "talker") == "/chatter"
    assert names.resolve_name("~/x", "talker") == "/talker/x"


@pytest.mark.parametrize("bad", ["", "a b", "1st", "a//b", "a/", "ä", "a__b", "a-b", "/x" * 200])
def test_invalid_names_are_refused(bad):
    with pytest.raises(InvalidName):
        names.resolve_name(bad, "node")


@pytest.mark.parametrize("bad", ["", "a b", "1st", "a/b", "ä"])
def test_invalid_node_names_are_refused(bad):
    with pytest.raises(InvalidName):
        names.validate_node_name(bad)


def test_topics_and_services_have_the_dds_names_of_ros():
    assert names.dds_topic_name(names.TOPIC, "/tf") == "rt/tf"
    assert names.dds_topic_name(names.REQUEST, "/a/set") == "rq/a/setRequest"
    assert names.dds_topic_name(names.REPLY, "/a/set") == "rr/a/setReply"


@pytest.mark.parametrize("kind", [names.TOPIC, names.REQUEST, names.REPLY])
def test_dds_names_are_parsed_back(kind):
    assert names.parse_dds_topic_name(names.dds_topic_name(kind, "/a/b")) == (kind, "/a/b")


def test_names_and_types_outside_ros_are_recognised():
    assert names.parse_dds_topic_name("ros_discovery_info") is None
    assert names.parse_dds_topic_name("rtfm") is None
    assert names.ros_type_name("My::Type") == "My::Type"
    assert names.ros_type_name("sensor_msgs::msg::dds_::Imu_") == "sensor_msgs/msg/Imu"


def test_service_type_follows_from_request_and_response():
    for part in ("Request", "Response"):
        assert names.service_type_name(f"std_srvs/srv/Trigger_{part}") == "std_srvs/srv/Trigger"


def test_name_with_a_part_that_begins_with_an_underscore_is_hidden():
    assert names.is_hidden("/walk/_action/status")
    assert names.is_hidden("/_tool")
    assert not names.is_hidden("/navigate")
