"""Services and parameters between two processes."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from rostools import TIMEOUT, MessageCollector, PeerProcess, node

from wbc.messages import message_type
from wbc.ros import QoSProfile, ResponseTimeout, RosError
from wbc.ros.type_descriptions import serve_type_descriptions

pytest.importorskip("cyclonedds")

SET_BOOL = "std_srvs/srv/SetBool"
ParameterType = message_type("rcl_interfaces/msg/ParameterType")
Parameter = message_type("rcl_interfaces/msg/Parameter")
Value = message_type("rcl_interfaces/msg/ParameterValue")


@pytest.fixture(scope="module")
def local_node(domain):
    with PeerProcess.start_peer(domain, "serve"), node("local", domain) as made:
        yield made


@pytest.fixture(scope="module")
def call(local_node):
    clients = {}

    def call_service(kind, **fields):
        name = "".join("_" + c.lower() if c.isupper() else c for c in kind)[1:]
        if kind not in clients:
            clients[kind] = local_node.create_client(
                f"rcl_interfaces/srv/{kind}", f"/peer_serve/{name}"
            )
        return clients[kind].call(clients[kind].request_type(**fields), TIMEOUT)

    return call_service


def value_of(call, name):
    return call("GetParameters", names=[name]).values[0]


def test_request_gets_a_response(local_node):
    client = local_node.create_client(SET_BOOL, "switch")
    first = client.call(client.request_type(data=True), TIMEOUT)
    second = client.call(client.request_type(data=False), TIMEOUT)
    assert (first.success, second.success) == (True, False)
    assert int(second.message.split()[1]) == int(first.message.split()[1]) + 1


def test_each_client_gets_its_own_responses(local_node, domain):
    with node("other", domain) as other:
        one, two = (
            local_node.create_client(SET_BOOL, "switch"),
            other.create_client(SET_BOOL, "switch"),
        )
        assert one.wait_for_service(TIMEOUT)
        assert two.wait_for_service(TIMEOUT)
        futures = {"one": [], "two": []}
        for _ in range(4):  # a service queues ten requests
            futures["one"].append(one.call_async(one.request_type(data=True)))
            futures["two"].append(two.call_async(two.request_type(data=False)))

        def complete():
            other.spin_once(0.0)
            return all(future.done() for pending in futures.values() for future in pending)

        assert local_node.spin_until(complete, TIMEOUT)
        assert all(future.result().success for future in futures["one"])
        assert not any(future.result().success for future in futures["two"])


def test_requests_and_replies_carry_the_header_of_rmw_cyclonedds(local_node):
    """The header follows the CDR header: uint64 handle of the client's writer, int64 number."""
    raw = []
    client = local_node.create_client(SET_BOOL, "switch")
    assert client.wait_for_service(TIMEOUT)
    write = client.writer.write
    client.writer.write = lambda data: (raw.append(bytes(data)), write(data))
    client.call(client.request_type(data=True), TIMEOUT)
    (data,) = raw
    assert data[:4] == b"\x00\x01\x00\x00"
    assert int.from_bytes(data[4:12], "little") == client.writer.handle
    assert int.from_bytes(data[12:20], "little") == 1
    assert data[20:] == b"\x01"


def test_a_hundred_calls_at_once_get_their_responses(local_node):
    client = local_node.create_client(SET_BOOL, "switch")
    assert client.wait_for_service(TIMEOUT)
    futures = [client.call_async(client.request_type(data=True)) for _ in range(100)]
    assert local_node.spin_until(lambda: all(future.done() for future in futures), TIMEOUT)


def test_a_node_describes_its_types_to_those_who_lack_them(local_node, domain):
    kind = "wbc_msgs/msg/ControllerState"
    with node("descriptions", domain) as server:
        serve_type_descriptions(server)
        client = local_node.create_client(
            "type_description_interfaces/srv/GetTypeDescription",
            "/descriptions/get_type_description",
        )

        def ask(name, type_hash):
            request = client.request_type(type_name=name, type_hash=type_hash)
            future = None

            def answered():
                nonlocal future
                server.spin_once(0.0)
                if future is None and client.service_is_ready():
                    future = client.call_async(request)
                return future is not None and future.done()

            assert local_node.spin_until(answered, TIMEOUT)
            return future.result()

        found = ask(kind, message_type(kind).type_hash())
        assert found.successful
        names = [field.name for field in found.type_description.type_description.fields]
        assert {"dcm_error", "phase"} <= set(names)
        refused = ask(kind, "RIHS01_0")
        assert not refused.successful
        assert message_type(kind).type_hash() in refused.failure_reason
        assert "a_msgs/msg/B" in ask("a_msgs/msg/B", "").failure_reason


def test_missing_server_raises_a_timeout(local_node):
    client = local_node.create_client(SET_BOOL, "no_such_service")
    with pytest.raises(ResponseTimeout, match="no server for /no_such_service"):
        client.call(client.request_type(), 0.2)


def test_request_of_another_service_is_refused(local_node):
    client = local_node.create_client(SET_BOOL, "switch")
    with pytest.raises(RosError, match="takes std_srvs/srv/SetBool_Request"):
        client.call_async(message_type("std_srvs/srv/Trigger_Request")())


def test_invalid_requests_are_skipped_and_valid_ones_get_a_response(local_node):
    from wbc.ros.dds_endpoints import DdsWriter, EndpointConfig
    from wbc.ros.dds_types import raw_dds_type
    from wbc.ros.qos import DEFAULT

    name = f"{message_type(SET_BOOL + '_Request').dds_name()}"
    writer = DdsWriter(
        local_node.participant.dds, EndpointConfig("rq/switchRequest", raw_dds_type(name), DEFAULT)
    )
    assert local_node.spin_until(lambda: writer.matched, TIMEOUT)
    for data in (b"\x00\x01\x00\x00" + bytes(8), b"\x00\x01\x00\x00" + b"\xff" * 64):
        writer.write(data)
    client = local_node.create_client(SET_BOOL, "switch")
    assert client.call(client.request_type(data=True), TIMEOUT).success


def test_parameters_are_listed_by_prefix_and_depth(call):
    every = ["built", "count", "gait.impulse", "name", "on", "rate"]
    assert call("ListParameters").result.names == every
    below = call("ListParameters", prefixes=["gait"]).result
    assert (below.names, below.prefixes) == (["gait.impulse"], ["gait"])
    assert "gait.impulse" not in call("ListParameters", depth=1).result.names
    assert call("ListParameters", prefixes=["none"]).result.names == []


def test_parameters_have_their_types_and_values(call):
    names = ["rate", "count", "on", "name", "gait.impulse", "undeclared"]
    kinds = [
        ParameterType.PARAMETER_DOUBLE,
        ParameterType.PARAMETER_INTEGER,
        ParameterType.PARAMETER_BOOL,
        ParameterType.PARAMETER_STRING,
        ParameterType.PARAMETER_DOUBLE_ARRAY,
        ParameterType.PARAMETER_NOT_SET,
    ]
    assert list(call("GetParameterTypes", names=names).types) == kinds
    rate, count, on, name, impulse, undeclared = call("GetParameters", names=names).values
    assert rate.double_value == 50.0
    assert count.integer_value == 3
    assert on.bool_value is True
    assert name.string_value == "text"
    assert np.array_equal(impulse.double_array_value, [0.0, 1.0, 2.0])
    assert undeclared.type == ParameterType.PARAMETER_NOT_SET


def test_parameters_are_described(call):
    rate, count, built, undeclared = call(
        "DescribeParameters", names=["rate", "count", "built", "undeclared"]
    ).descriptors
    assert (rate.name, rate.type, rate.description) == (
        "rate",
        ParameterType.PARAMETER_DOUBLE,
        "Hz",
    )
    (span,) = rate.floating_point_range
    assert (span.from_value, span.to_value) == (1.0, 500.0)
    (whole,) = count.integer_range
    assert (whole.from_value, whole.to_value) == (0, 10)
    assert built.read_only
    assert not rate.read_only
    assert undeclared.type == ParameterType.PARAMETER_NOT_SET


def test_parameter_is_set_and_the_event_is_published(local_node, call):
    events = MessageCollector(
        local_node, "rcl_interfaces/msg/ParameterEvent", "/parameter_events", QoSProfile(depth=1000)
    )
    # A response shows that the peer has discovered this node with all its subscriptions.
    client = local_node.create_client(SET_BOOL, "switch")
    client.call(client.request_type(), TIMEOUT)
    new = Parameter(
        name="rate", value=Value(type=ParameterType.PARAMETER_DOUBLE, double_value=100.0)
    )
    (result,) = call("SetParameters", parameters=[new]).results
    assert result.successful
    assert value_of(call, "rate").double_value == 100.0
    event = events.last if len(events) else events.wait()
    assert event.node == "/peer_serve"
    assert event.changed_parameters[0].value.double_value == 100.0


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        (
            "rate",
            {"type": ParameterType.PARAMETER_DOUBLE, "double_value": 501.0},
            "out of its range, 1 to 500",
        ),
        (
            "rate",
            {"type": ParameterType.PARAMETER_DOUBLE, "double_value": math.nan},
            "out of its range",
        ),
        (
            "rate",
            {"type": ParameterType.PARAMETER_STRING, "string_value": "fast"},
            "type double, not string",
        ),
        (
            "count",
            {"type": ParameterType.PARAMETER_INTEGER, "integer_value": -1},
            "out of its range, 0 to 10",
        ),
        (
            "count",
            {"type": ParameterType.PARAMETER_DOUBLE, "double_value": 1.0},
            "type integer, not double",
        ),
        ("on", {"type": ParameterType.PARAMETER_NOT_SET}, "on cannot be deleted"),
        (
            "built",
            {"type": ParameterType.PARAMETER_STRING, "string_value": "never"},
            "is read-only",
        ),
        (
            "undeclared",
            {"type": ParameterType.PARAMETER_BOOL},
            "there is no parameter 'undeclared'",
        ),
        (
            "gait.impulse",
            {"type": ParameterType.PARAMETER_DOUBLE_ARRAY, "double_array_value": [0.0, 0.0, 11.0]},
            "11 is out of its range",
        ),
        (
            "gait.impulse",
            {"type": ParameterType.PARAMETER_DOUBLE_ARRAY, "double_array_value": [0.0]},
            "3 numbers",
        ),
        ("rate", {"type": 77}, "unknown (77)"),
    ],
)
def test_invalid_value_is_refused_with_the_reason(call, name, value, reason):
    before = value_of(call, name)
    new = Parameter(name=name, value=Value(**value))
    (result,) = call("SetParameters", parameters=[new]).results
    assert not result.successful
    assert reason in result.reason
    assert value_of(call, name) == before


def test_integer_is_accepted_for_a_double(call):
    new = Parameter(
        name="rate", value=Value(type=ParameterType.PARAMETER_INTEGER, integer_value=200)
    )
    assert call("SetParameters", parameters=[new]).results[0].successful
    assert value_of(call, "rate").double_value == 200.0


def test_setting_atomically_sets_all_parameters_or_none(call):
    good = Parameter(
        name="count", value=Value(type=ParameterType.PARAMETER_INTEGER, integer_value=9)
    )
    bad = Parameter(name="rate", value=Value(type=ParameterType.PARAMETER_DOUBLE, double_value=0.0))
    before = value_of(call, "count").integer_value
    assert before != 9
    refused = call("SetParametersAtomically", parameters=[good, bad]).result
    assert not refused.successful
    assert "rate = 0" in refused.reason
    assert value_of(call, "count").integer_value == before
    assert call("SetParametersAtomically", parameters=[good]).result.successful
    assert value_of(call, "count").integer_value == 9


def test_parameter_is_declared_once_and_within_its_range(domain):
    with node("own", domain) as own:
        own.declare_parameter("x", 1.0, bounds=(0.0, 2.0))
        with pytest.raises(RosError, match="already declared"):
            own.declare_parameter("x", 1.0)
        with pytest.raises(RosError, match="out of its range"):
            own.declare_parameter("y", 3.0, bounds=(0.0, 2.0))
        with pytest.raises(RosError, match="use a bool"):
            own.declare_parameter("z", object())


def test_service_waits_for_a_client_whose_reader_is_not_matched_yet(local_node, domain):
    """A client that calls before discovery is complete gets its response."""
    for _ in range(5):
        with node("early", domain) as early:
            client = early.create_client(SET_BOOL, "switch")
            assert early.spin_until(lambda client=client: client.writer.matched, TIMEOUT)
            future = client.call_async(client.request_type(data=True))
            assert early.spin_until_future_complete(future, TIMEOUT)
            assert future.result().success


def test_timers_do_not_make_up_for_missed_calls(domain):
    with node("clock", domain) as clock:
        calls = []
        clock.create_timer(0.02, lambda: calls.append(time.monotonic()))
        time.sleep(0.3)  # fifteen periods late
        clock.spin_once(0.0)
        clock.spin_once(0.0)
        assert len(calls) <= 2
        with pytest.raises(RosError, match="must be positive"):
            clock.create_timer(0.0, lambda: None)
