"""Names are those of ROS 2, and what it makes of them in DDS."""

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
def test_names_are_resolved_as_ros_does(name, full):
    assert names.resolve_name(name, "legs", "/robot") == full


def test_the_root_namespace_adds_nothing():
    assert names.resolve_name("chatter", "talker") == "/chatter"
    assert names.resolve_name("~/x", "talker") == "/talker/x"


@pytest.mark.parametrize("bad", ["", "a b", "1st", "a//b", "a/", "ä", "a__b", "a-b", "/x" * 200])
def test_names_that_ros_refuses_are_refused(bad):
    with pytest.raises(InvalidName):
        names.resolve_name(bad, "node")


@pytest.mark.parametrize("bad", ["", "a b", "1st", "a/b", "ä"])
def test_names_of_nodes_that_ros_refuses_are_refused(bad):
    with pytest.raises(InvalidName):
        names.validate_node_name(bad)


def test_topics_and_services_have_their_names_in_dds():
    assert names.dds_topic_name(names.TOPIC, "/tf") == "rt/tf"
    assert names.dds_topic_name(names.REQUEST, "/a/set") == "rq/a/setRequest"
    assert names.dds_topic_name(names.REPLY, "/a/set") == "rr/a/setReply"


@pytest.mark.parametrize("kind", [names.TOPIC, names.REQUEST, names.REPLY])
def test_names_in_dds_are_read_back(kind):
    assert names.parse_dds_topic_name(names.dds_topic_name(kind, "/a/b")) == (kind, "/a/b")


def test_what_is_none_of_ros_is_told_apart():
    assert names.parse_dds_topic_name("ros_discovery_info") is None
    assert names.parse_dds_topic_name("rtfm") is None
    assert names.ros_type_name("My::Type") == "My::Type"
    assert names.ros_type_name("sensor_msgs::msg::dds_::Imu_") == "sensor_msgs/msg/Imu"


def test_a_service_is_named_by_either_of_its_messages():
    for part in ("Request", "Response"):
        assert names.service_type_name(f"std_srvs/srv/Trigger_{part}") == "std_srvs/srv/Trigger"


def test_any_text_becomes_a_part_of_a_name():
    for text in ("left_sole", "left sole", "1st", "", "l-foot__x", "Fuß"):
        made = names.to_name_token(text)
        assert names.resolve_name(f"/{made}", "node") == f"/{made}"
    assert names.to_name_token("left_sole") == "left_sole"


def test_hidden_names_have_a_part_that_starts_with_an_underscore():
    assert names.is_hidden("/walk/_action/status")
    assert names.is_hidden("/_tool")
    assert not names.is_hidden("/walk_to")
