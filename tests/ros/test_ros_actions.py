"""Actions between two processes: feedback, result, cancellation, and clients that die."""

from __future__ import annotations

import pytest
from rospeer import ACTION
from rostools import SHORT_LEASE, TIMEOUT, MessageCollector, PeerProcess, node

from wbc.messages import message_type
from wbc.ros import ResponseTimeout
from wbc.ros.actions import ActionClient, GoalStatus
from wbc.ros.qos import LATCHED

pytest.importorskip("cyclonedds")

CANCEL = "action_msgs/srv/CancelGoal"
FAR = 1e6


@pytest.fixture(scope="module")
def server(domain):
    with PeerProcess.start_peer(domain, "serve") as peer:
        yield peer


@pytest.fixture(scope="module")
def local_node(server, domain):
    with node("local", domain) as made:
        yield made


@pytest.fixture(scope="module")
def client(local_node):
    made = ActionClient(local_node, ACTION, "walk")
    assert made.wait_for_server(TIMEOUT)
    return made


def goal(client, x):
    request = client.goal_type()
    request.pose.pose.position.x = x
    return request


def test_goal_gets_feedback_and_a_result(client):
    remaining = []
    sent = client.send_goal(goal(client, 5.0), lambda f: remaining.append(f.distance_remaining))
    assert sent.accepted
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.SUCCEEDED
    assert sent.result.error_msg == "arrived"
    assert remaining == [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]


def test_server_can_reject_a_goal(client):
    sent = client.send_goal(goal(client, -1.0))
    assert sent.accepted is False
    assert not sent.wait_for_result(0.1)


def test_goal_in_progress_can_be_cancelled(client):
    sent = client.send_goal(goal(client, FAR))
    assert sent.cancel_goal()
    assert sent.wait_for_result(TIMEOUT)
    assert sent.status is GoalStatus.CANCELED
    assert sent.result.error_msg == "cancelled"


def test_finished_goal_cannot_be_cancelled(client):
    sent = client.send_goal(goal(client, 0.0))
    assert sent.wait_for_result(TIMEOUT)
    assert not sent.cancel_goal()


def test_cancel_request_without_an_id_cancels_all_goals(client, local_node):
    goals = [client.send_goal(goal(client, FAR)) for _ in range(2)]
    every = local_node.create_client(CANCEL, "walk/_action/cancel_goal")
    response = every.call(every.request_type(), TIMEOUT)
    assert response.return_code == 0
    assert {bytes(i.goal_id.uuid) for i in response.goals_canceling} >= {g.goal_id for g in goals}
    assert all(g.wait_for_result(TIMEOUT) and g.status is GoalStatus.CANCELED for g in goals)


def test_requests_for_an_unknown_goal_return_an_error_code(local_node, client):
    cancel = local_node.create_client(CANCEL, "walk/_action/cancel_goal")
    request = cancel.request_type()
    request.goal_info.goal_id.uuid = list(range(16))
    assert cancel.call(request, TIMEOUT).return_code == 2  # ERROR_UNKNOWN_GOAL_ID
    result = local_node.create_client(f"{ACTION}_GetResult", "walk/_action/get_result")
    request = result.request_type()
    request.goal_id.uuid = list(range(16))
    assert result.call(request, TIMEOUT).status == GoalStatus.UNKNOWN


def test_status_topic_is_latched(local_node, client):
    sent = client.send_goal(goal(client, 0.0))
    assert sent.wait_for_result(TIMEOUT)
    status = MessageCollector(
        local_node, "action_msgs/msg/GoalStatusArray", "walk/_action/status", LATCHED
    )
    last = status.wait()
    statuses = {bytes(s.goal_info.goal_id.uuid): s.status for s in last.status_list}
    assert statuses[sent.goal_id] == GoalStatus.SUCCEEDED


def test_goal_with_a_used_id_is_rejected(local_node, client):
    send_goal = local_node.create_client(f"{ACTION}_SendGoal", "walk/_action/send_goal")
    request = send_goal.request_type()
    request.goal_id.uuid = list(range(1, 17))
    assert send_goal.call(request, TIMEOUT).accepted
    assert not send_goal.call(request, TIMEOUT).accepted


def test_missing_server_raises_a_timeout(local_node):
    client = ActionClient(local_node, ACTION, "no_such_action")
    with pytest.raises(ResponseTimeout, match="no_such_action"):
        client.send_goal(client.goal_type(), timeout_sec=0.2)


def test_goal_status_equals_the_constants_of_action_msgs():
    constants = message_type("action_msgs/msg/GoalStatus")
    for status in GoalStatus:
        assert getattr(constants, f"STATUS_{status.name}") == status


def test_server_notices_that_the_client_of_a_goal_died(server, domain):
    with PeerProcess.start_peer(
        domain, "send_goal", str(FAR), "walk", configuration=SHORT_LEASE
    ) as peer:
        assert peer.first_line == "accepted"
        peer.kill()
    assert server.read_line() == "client lost"
