"""Messages have the bytes, the definitions and the hashes that ROS 2 gives them."""

import hashlib
import json
import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rostools import random_message, used_types

from wbc.messages import MessageError, message_layout, message_type, type_description

JointState = message_type("sensor_msgs/msg/JointState")
Twist = message_type("geometry_msgs/msg/Twist")
TFMessage = message_type("tf2_msgs/msg/TFMessage")
TransformStamped = message_type("geometry_msgs/msg/TransformStamped")


@pytest.mark.parametrize("name", used_types())
def test_every_type_is_read_as_it_was_written(name):
    for seed in range(3):
        message = random_message(name, seed)
        data = message.encode()
        again = type(message).decode(data)
        assert repr(again) == repr(message)
        assert again.encode() == data


def test_type_hashes_are_those_that_ros_prints():
    # From `ros2 topic info --verbose` and `ros2 service info --verbose` of public logs.
    assert Twist.type_hash() == (
        "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
    )
    assert message_type("rmw_dds_common/msg/ParticipantEntitiesInfo").type_hash() == (
        "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"
    )


def test_a_schema_has_every_type_inside_once():
    text = message_type("nav_msgs/msg/Odometry").schema()
    assert text.startswith("std_msgs/Header header\n")
    named = [line for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(named) == sorted(set(named))
    assert "MSG: geometry_msgs/PoseWithCovariance" in named
    assert "MSG: geometry_msgs/Vector3" in named


def test_a_joint_state_has_the_known_bytes():
    message = JointState(name=["knee", "hip"], position=[0.5, -1.0])
    message.header.stamp.sec = 3
    message.header.stamp.nanosec = 7
    message.header.frame_id = "base"
    assert message.encode().hex(" ", 4) == (
        "00010000 03000000 07000000 05000000 62617365 00000000 02000000 05000000 6b6e6565 00000000 "
        "04000000 68697000 02000000 00000000 0000e03f 00000000 0000f0bf 00000000 00000000"
    )


def test_an_empty_request_has_the_known_bytes():
    assert message_type("std_srvs/srv/Empty_Request")().encode() == b"\0\1\0\0\0"


def test_an_action_goal_has_the_known_bytes():
    message = message_type("play_motion2_msgs/action/PlayMotion2_SendGoal_Request")()
    message.goal_id.uuid = range(16)
    message.goal.motion_name = "wave"
    assert message.encode()[:29].hex() == (
        "00010000" + "000102030405060708090a0b0c0d0e0f" + "05000000" + "7761766500"
    )


def test_big_endian_bytes_are_read():
    data = bytes.fromhex("00000000 3ff00000 00000000") + bytes(40)
    assert Twist.decode(data).linear.x == 1.0


def test_defaults_are_those_of_the_definition():
    assert message_type("geometry_msgs/msg/Pose")().orientation.w == 1.0
    assert message_type("nav_msgs/msg/Odometry")().pose.covariance.shape == (36,)
    assert message_type("wbc_msgs/msg/ControllerState").STATUS_FAILED == 2


def test_arrays_of_a_received_message_are_writable():
    received = JointState.decode(JointState(position=[0.5]).encode())
    received.position[0] = 1.0
    assert JointState.decode(received.encode()).position.tolist() == [1.0]


@pytest.mark.parametrize(
    ("name", "field", "value", "says"),
    [
        ("sensor_msgs/msg/JointState", "position", "knee", "position = 'knee'"),
        ("sensor_msgs/msg/JointState", "name", [3], r"name = \[3\]: it must be a string"),
        ("sensor_msgs/msg/JointState", "position", [[1.0]], r"shape \(1, 1\)"),
        ("sensor_msgs/msg/JointState", "positions", [1.0], "did you mean 'position'"),
        ("geometry_msgs/msg/Twist", "linear", 3, "it must be a geometry_msgs/msg/Vector3"),
        ("nav_msgs/msg/Odometry", "child_frame_id", None, "child_frame_id = None"),
        ("builtin_interfaces/msg/Time", "sec", 2**31, "sec = 2147483648: .* int32"),
        ("builtin_interfaces/msg/Time", "sec", 0.5, "sec = 0.5"),
        ("unique_identifier_msgs/msg/UUID", "uuid", [1, 2], "it must be between 16 and 16"),
        ("sensor_msgs/msg/Joy", "buttons", [1.5], "its numbers must be of type int32"),
        ("sensor_msgs/msg/Joy", "buttons", [math.nan], "its numbers must be of type int32"),
        ("sensor_msgs/msg/Joy", "buttons", np.array([2**40]), "its numbers must be of type int32"),
        (
            "rcl_interfaces/msg/ParameterDescriptor",
            "integer_range",
            [message_type("rcl_interfaces/msg/IntegerRange")()] * 2,
            "it must be between 0 and 1",
        ),
        (
            "rmw_dds_common/msg/NodeEntitiesInfo",
            "node_name",
            "n" * 257,
            "it must be between 0 and 256",
        ),
    ],
)
def test_a_value_that_does_not_fit_is_named(name, field, value, says):
    with pytest.raises(MessageError, match=says):
        setattr(message_type(name)(), field, value)


def test_an_element_that_does_not_fit_is_refused():
    message = TFMessage()
    message.transforms.append(3)
    with pytest.raises(MessageError, match="tf2_msgs/msg/TFMessage cannot be serialized"):
        message.encode()


@given(st.binary(max_size=200))
@settings(max_examples=200, database=None)
def test_random_bytes_give_a_message_or_a_message_error(data):
    for kind in (JointState, TFMessage):
        for header in (b"", b"\0\1\0\0"):
            try:
                kind.decode(header + data)
            except MessageError:
                continue


def test_every_truncation_of_a_message_is_refused():
    message = JointState(name=["knee"], position=[0.5], velocity=[0.1], effort=[2.0])
    data = message.encode()
    for size in range(len(data)):
        with pytest.raises(MessageError):
            JointState.decode(data[:size])
    assert JointState.decode(data + bytes(3)).encode() == data  # DDS pads to whole words


def test_an_impossible_length_allocates_no_memory():
    with pytest.raises(MessageError, match="4294967295"):
        JointState.decode(b"\0\1\0\0" + bytes(8) + b"\1\0\0\0\0\0\0\0" + b"\xff\xff\xff\xff")


@pytest.mark.parametrize("name", ["sensor_msgs/msg/JointStates", "sensor_msgs/JointState"])
def test_an_unknown_type_is_refused_with_similar_names(name):
    with pytest.raises(MessageError, match="did you mean 'sensor_msgs/msg/JointState'"):
        message_type(name)


def test_columns_of_many_messages_are_written_by_their_layout():
    names = [f"joint_{i}" for i in range(32)]
    message = JointState(name=names, position=np.zeros(32), effort=np.zeros(32))
    rows = np.tile(np.frombuffer(message.encode(), np.uint8), (2, 1))
    fields = rows.view(message_layout(message))[:, 0]
    fields["position"] = np.arange(64.0).reshape(2, 32)
    fields["header.stamp.sec"] = [7, 8]
    second = JointState.decode(rows[1].tobytes())
    assert second.name == names
    assert second.position.tolist() == list(range(32, 64))
    assert second.header.stamp.sec == 8


def test_a_layout_reaches_into_messages_in_arrays():
    names = ("pelvis", "left_foot_link")
    message = TFMessage(transforms=[TransformStamped(child_frame_id=n) for n in names])
    data = bytearray(message.encode())
    fields = np.frombuffer(data, message_layout(message))
    fields["transforms[1].transform"] = [1, 2, 3, 0, 0, 0, 1]
    found = TFMessage.decode(data)
    assert [t.child_frame_id for t in found.transforms] == list(names)
    assert found.transforms[1].transform.translation.z == 3.0
    assert found.transforms[0].transform.translation.z == 0.0


@pytest.mark.parametrize("name", used_types())
def test_a_layout_finds_every_number(name):
    message = random_message(name, seed=1)
    fields = np.frombuffer(message.encode(), message_layout(message))
    for path in fields.dtype.names or ():
        value = message
        for step in path.replace("[", ".[").split("."):
            value = value[int(step[1:-1])] if step.startswith("[") else getattr(value, step)
        if not hasattr(value, "type_name"):
            assert np.array_equal(fields[path][0], value), path


def test_numbers_of_several_types_are_not_one_field():
    names = message_layout(JointState(position=[0.0])).names
    assert "header.stamp.sec" in names
    assert "header.stamp" not in names
    assert "effort" not in names  # empty


def test_rosbags_is_loaded_with_the_first_message_type():
    code = """
import sys, wbc, wbc.log, wbc.messages
print(sorted({"rosbags", "mcap", "cyclonedds"} & set(sys.modules)))
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.strip() == "[]", result.stderr


def test_a_missing_rosbags_is_named_with_the_command_that_brings_it():
    code = """
import sys
sys.modules["rosbags"] = None
import wbc.messages
wbc.messages.message_type("std_msgs/msg/String")
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "pip install 'wbc[ros2]'" in result.stderr


def described(one):
    """The form of a description of which a type's hash is made (REP 2016)."""
    names = ("type_id", "capacity", "string_capacity", "nested_type_name")
    fields = [
        {"name": field.name, "type": {name: getattr(field.type, name) for name in names}}
        for field in one.fields
    ]
    return {"type_name": one.type_name, "fields": fields}


@pytest.mark.parametrize("name", used_types())
def test_the_description_of_a_type_has_its_hash(name):
    found = type_description(name)
    content = {
        "type_description": described(found.type_description),
        "referenced_type_descriptions": [
            described(one) for one in found.referenced_type_descriptions
        ],
    }
    digest = hashlib.sha256(json.dumps(content).encode()).hexdigest()
    assert f"RIHS01_{digest}" == message_type(name).type_hash()


def test_an_unknown_type_has_no_description():
    with pytest.raises(MessageError, match="no message type 'a_msgs/msg/B'"):
        type_description("a_msgs/msg/B")
