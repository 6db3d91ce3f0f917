"""Actions, between two processes: feedback, result, cancelling, and clients that die."""

from __future__ import annotations

import pytest
from rospeer import ACTION
from rostools import PATIENCE, SHORT_LIVED, Hearer, Peer, node

from wbc.messages import message_type
from wbc.ros import ResponseTimeout
from wbc.ros.actions import ActionClient, GoalStatus
from wbc.ros.qos import LATCHED

pytest.importorskip("cyclonedds")

CANCEL = "action_msgs/srv/CancelGoal"
FAR = 1e6


@pytest.fixture(scope="module")
def server(domain):
    with Peer.of(domain, "serve") as peer:
        yield peer


@pytest.fixture(scope="module")
def here(server, domain):
    with node("here", domain) as made:
        yield made


@pytest.fixture(scope="module")
def client(here):
    made = ActionClient(here, ACTION, "walk")
    assert made.wait_for_server(PATIENCE)
    return made


def goal(client, x):
    request = client.goal_type()
    request.pose.pose.position.x = x
    return request


def test_a_goal_gets_feedback_and_a_result(client):
    remaining = []
    sent = client.send_goal(goal(client, 5.0), lambda f: remaining.append(f.distance_remaining))
    assert sent.accepted
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.SUCCEEDED
    assert sent.result.error_msg == "there"
    assert remaining == [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]


def test_a_goal_may_be_rejected(client):
    sent = client.send_goal(goal(client, -1.0))
    assert sent.accepted is False
    assert not sent.wait_for_result(0.1)


def test_a_goal_is_cancelled_at_any_moment(client):
    sent = client.send_goal(goal(client, FAR))
    assert sent.cancel_goal()
    assert sent.wait_for_result(PATIENCE)
    assert sent.status is GoalStatus.CANCELED
    assert sent.result.error_msg == "cancelled"


def test_a_goal_that_is_over_cannot_be_cancelled(client):
    sent = client.send_goal(goal(client, 0.0))
    assert sent.wait_for_result(PATIENCE)
    assert not sent.cancel_goal()


def test_cancelling_without_an_id_cancels_everything(client, here):
    goals = [client.send_goal(goal(client, FAR)) for _ in range(2)]
    every = here.create_client(CANCEL, "walk/_action/cancel_goal")
    response = every.call(every.request_type(), PATIENCE)
    assert response.return_code == 0
    assert {bytes(i.goal_id.uuid) for i in response.goals_canceling} >= {g.goal_id for g in goals}
    assert all(g.wait_for_result(PATIENCE) and g.status is GoalStatus.CANCELED for g in goals)


def test_a_goal_that_nobody_knows_is_told(here, client):
    cancel = here.create_client(CANCEL, "walk/_action/cancel_goal")
    request = cancel.request_type()
    request.goal_info.goal_id.uuid = list(range(16))
    assert cancel.call(request, PATIENCE).return_code == 2  # ERROR_UNKNOWN_GOAL_ID
    result = here.create_client(f"{ACTION}_GetResult", "walk/_action/get_result")
    asked = result.request_type()
    asked.goal_id.uuid = list(range(16))
    assert result.call(asked, PATIENCE).status == GoalStatus.UNKNOWN


def test_the_status_is_latched(here, client):
    sent = client.send_goal(goal(client, 0.0))
    assert sent.wait_for_result(PATIENCE)
    status = Hearer(here, "action_msgs/msg/GoalStatusArray", "walk/_action/status", LATCHED)
    last = status.wait()
    states = {bytes(s.goal_info.goal_id.uuid): s.status for s in last.status_list}
    assert states[sent.goal_id] == GoalStatus.SUCCEEDED


def test_an_id_that_was_used_is_rejected(here, client):
    ask = here.create_client(f"{ACTION}_SendGoal", "walk/_action/send_goal")
    request = ask.request_type()
    request.goal_id.uuid = list(range(1, 17))
    assert ask.call(request, PATIENCE).accepted
    assert not ask.call(request, PATIENCE).accepted


def test_nobody_answers_where_nobody_serves(here):
    lonely = ActionClient(here, ACTION, "no_such_action")
    with pytest.raises(ResponseTimeout, match="no_such_action"):
        lonely.send_goal(lonely.goal_type(), timeout_sec=0.2)


def test_states_are_those_of_action_msgs():
    constants = message_type("action_msgs/msg/GoalStatus")
    for state in GoalStatus:
        assert getattr(constants, f"STATUS_{state.name}") == state


def test_a_client_that_dies_in_the_middle_is_noticed(server, domain):
    with Peer.of(domain, "pursue", str(FAR), "walk", configuration=SHORT_LIVED) as peer:
        assert peer.first == "accepted"
        peer.kill()
    assert server.line() == "orphan"
