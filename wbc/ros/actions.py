"""Actions: goals that take time, with feedback, a result, and a way to cancel them.

An action is three services (`send_goal`, `cancel_goal`, `get_result`) and two topics (`feedback`,
`status`) below `<name>/_action`. Source: ROS 2 design, "Actions".
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, message_type
from wbc.ros.errors import NoAnswer
from wbc.ros.qos import ACTION_STATUS
from wbc.ros.stamp import stamp_now

if TYPE_CHECKING:
    from wbc.ros.node import Node
    from wbc.ros.services import Reply

_CANCEL = "action_msgs/srv/CancelGoal"
_CANCEL_RESPONSE = message_type(f"{_CANCEL}_Response")
_INFO = message_type("action_msgs/msg/GoalInfo")
_STATUS = message_type("action_msgs/msg/GoalStatus")
_STATUS_ARRAY = message_type("action_msgs/msg/GoalStatusArray")
_KEPT = 60.0  # s that a result can be asked for


class GoalState(IntEnum):
    """How far a goal is, as in `action_msgs/msg/GoalStatus`."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def over(self) -> bool:
        """Whether nothing will change any more."""
        return self >= GoalState.SUCCEEDED


class Goal:
    """A goal that somebody has sent, in the hands of the server.

    Attributes:
        id: 16 bytes.
        request: the goal's message.
        state: how far it is.
    """

    def __init__(self, server: ActionServer, goal_id: bytes, request: Any, reply: Reply) -> None:
        self._server, self._reply = server, reply
        self.id, self.request = goal_id, request
        self.state = GoalState.ACCEPTED
        self.info = _INFO(stamp=stamp_now())
        self.info.goal_id.uuid = list(goal_id)
        self.result: Message | None = None
        self.over_at = float("inf")
        self.waiting: list[Reply] = []

    @property
    def client_alive(self) -> bool:
        """Whether whoever sent it is still there."""
        return self._reply.client_alive

    def feedback(self, message: Message) -> None:
        """Tell how it goes."""
        self._server.tell(self, message)

    def finish(self, state: GoalState, result: Message) -> None:
        """End it: SUCCEEDED, CANCELED or ABORTED. A goal that is over stays as it is."""
        if not self.state.over:
            self._server.finish(self, state, result)


class ActionServer:
    """Serves an action.

    Args:
        node: through which.
        type_name: `pkg/action/Name`.
        name: of the action.
        accept: whether a goal's message can be pursued.
        begin: called with each goal that was accepted; from then on it is being executed.
        cancel: whether a goal can be cancelled; it is then up to the server to finish it.

    Attributes:
        goal_type: class of the goals' messages.
        result_type: class of the results.
        feedback_type: class of the feedback.
        goals: those that are known, by id.
    """

    def __init__(
        self,
        node: Node,
        type_name: str,
        name: str,
        accept: Callable[[Any], bool],
        begin: Callable[[Goal], None],
        cancel: Callable[[Goal], bool],
    ) -> None:
        self._accept, self._begin, self._cancel = accept, begin, cancel
        self.goal_type = message_type(f"{type_name}_Goal")
        self.result_type = message_type(f"{type_name}_Result")
        self.feedback_type = message_type(f"{type_name}_Feedback")
        self._feedback_message = message_type(f"{type_name}_FeedbackMessage")
        self._goal_response = message_type(f"{type_name}_SendGoal_Response")
        self._result_response = message_type(f"{type_name}_GetResult_Response")
        self.goals: dict[bytes, Goal] = {}
        below = f"{node.resolve(name)}/_action"
        node.service_with_reply(f"{type_name}_SendGoal", f"{below}/send_goal", self._send_goal)
        node.service(_CANCEL, f"{below}/cancel_goal", self._cancel_goal)
        node.service_with_reply(f"{type_name}_GetResult", f"{below}/get_result", self._get_result)
        self._feedback = node.publisher(self._feedback_message.type_name, f"{below}/feedback")
        self._status = node.publisher(_STATUS_ARRAY.type_name, f"{below}/status", ACTION_STATUS)
        self._tell_status()

    def _send_goal(self, request: Any, reply: Reply) -> None:
        goal_id = bytes(request.goal_id.uuid)
        self._forget()
        accepted = goal_id not in self.goals and self._accept(request.goal)
        reply.send(self._goal_response(accepted=accepted, stamp=stamp_now()))
        if not accepted:
            return
        goal = self.goals[goal_id] = Goal(self, goal_id, request.goal, reply)
        goal.state = GoalState.EXECUTING
        self._tell_status()
        self._begin(goal)

    def _get_result(self, request: Any, reply: Reply) -> None:
        goal = self.goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            reply.send(self._result_response(status=GoalState.UNKNOWN))
        elif goal.result is not None:
            reply.send(self._result_response(status=goal.state, result=goal.result))
        else:
            goal.waiting.append(reply)

    def _cancel_goal(self, request: Any) -> Message:
        """All goals, one goal, or those from before some time; see `CancelGoal`."""
        wanted, stamp = bytes(request.goal_info.goal_id.uuid), request.goal_info.stamp
        before = (stamp.sec, stamp.nanosec)
        everything = not any(wanted) and before == (0, 0)
        if any(wanted) and wanted not in self.goals:
            return _CANCEL_RESPONSE(return_code=_CANCEL_RESPONSE_CODES["UNKNOWN_GOAL_ID"])
        if any(wanted) and before == (0, 0) and self.goals[wanted].state.over:
            return _CANCEL_RESPONSE(return_code=_CANCEL_RESPONSE_CODES["GOAL_TERMINATED"])
        cancelled = []
        for goal in tuple(self.goals.values()):
            accepted = (goal.info.stamp.sec, goal.info.stamp.nanosec)
            meant = everything or goal.id == wanted or (before != (0, 0) and accepted <= before)
            if meant and not goal.state.over and self._cancel(goal):
                if not goal.state.over:
                    goal.state = GoalState.CANCELING
                cancelled.append(goal.info)
        self._tell_status()
        code = "NONE" if cancelled else "REJECTED"
        return _CANCEL_RESPONSE(return_code=_CANCEL_RESPONSE_CODES[code], goals_canceling=cancelled)

    def tell(self, goal: Goal, message: Message) -> None:
        """See `Goal.feedback`."""
        self._feedback.publish(self._feedback_message(goal_id=goal.info.goal_id, feedback=message))

    def finish(self, goal: Goal, state: GoalState, result: Message) -> None:
        """See `Goal.finish`."""
        goal.state, goal.result = state, result
        goal.over_at = time.monotonic()
        self._tell_status()
        waiting, goal.waiting = goal.waiting, []
        for reply in waiting:
            reply.send(self._result_response(status=state, result=result))

    def _forget(self) -> None:
        old = time.monotonic() - _KEPT
        self.goals = {key: goal for key, goal in self.goals.items() if goal.over_at > old}

    def _tell_status(self) -> None:
        self._status.publish(
            _STATUS_ARRAY(
                status_list=[_STATUS(goal_info=g.info, status=g.state) for g in self.goals.values()]
            )
        )


_CANCEL_RESPONSE_CODES = {"NONE": 0, "REJECTED": 1, "UNKNOWN_GOAL_ID": 2, "GOAL_TERMINATED": 3}


class SentGoal:
    """A goal, in the hands of whoever sent it.

    Attributes:
        id: 16 bytes.
        accepted: whether the server pursues it; None: not known yet.
        state: UNKNOWN until it is over.
        result: the result's message, when it is over.
    """

    def __init__(self, client: ActionClient, goal_id: bytes) -> None:
        self._client = client
        self.id = goal_id
        self.accepted: bool | None = None
        self.state = GoalState.UNKNOWN
        self.result: Any = None

    def cancel(self, timeout: float = 5.0) -> bool:
        """Ask the server to cancel it; whether it agreed.

        Raises:
            NoAnswer: the server did not answer in time.
        """
        return self._client.cancel(self, timeout)

    def wait(self, timeout: float) -> bool:
        """Wait until it is over; whether it is."""
        return self._client.node.spin(lambda: self.state.over, timeout)


class ActionClient:
    """Sends goals to an action.

    Args:
        node: through which.
        type_name: `pkg/action/Name`.
        name: of the action.

    Attributes:
        node: through which.
        goal_type: class of the goals' messages.
    """

    def __init__(self, node: Node, type_name: str, name: str) -> None:
        self.node = node
        self.goal_type = message_type(f"{type_name}_Goal")
        below = f"{node.resolve(name)}/_action"
        self._heard: dict[bytes, Callable[[Any], None]] = {}
        self._feedback = node.subscription(
            f"{type_name}_FeedbackMessage", f"{below}/feedback", lambda m, _: self._hear(m)
        )
        self._send = node.client(f"{type_name}_SendGoal", f"{below}/send_goal")
        self._cancel = node.client(_CANCEL, f"{below}/cancel_goal")
        self._result = node.client(f"{type_name}_GetResult", f"{below}/get_result")

    def wait(self, timeout: float) -> bool:
        """Wait until somebody serves the action; whether somebody does."""
        clients = (self._send, self._cancel, self._result)
        return self.node.spin(lambda: all(c.available for c in clients), timeout)

    def send(
        self,
        request: Message,
        feedback: Callable[[Any], None] = lambda _: None,
        timeout: float = 5.0,
    ) -> SentGoal:
        """Send a goal, and wait until it is accepted or not.

        Raises:
            NoAnswer: nobody serves the action, or it did not answer in time.
        """
        if not self.wait(timeout):
            raise NoAnswer(f"nobody serves the action {self._send.name.rpartition('/_action')[0]}")
        goal = SentGoal(self, uuid.uuid4().bytes)
        asked = self._send.request_type(goal=request)
        asked.goal_id.uuid = list(goal.id)
        self._heard[goal.id] = feedback
        goal.accepted = bool(self._send.call(asked, timeout).accepted)
        if goal.accepted:
            ask = self._result.request_type()
            ask.goal_id.uuid = list(goal.id)
            self._result.send(ask, lambda response: self._over(goal, response))
        else:
            del self._heard[goal.id]
        return goal

    def cancel(self, goal: SentGoal, timeout: float) -> bool:
        """See `SentGoal.cancel`."""
        asked = self._cancel.request_type()
        asked.goal_info.goal_id.uuid = list(goal.id)
        response = self._cancel.call(asked, timeout)
        return any(bytes(info.goal_id.uuid) == goal.id for info in response.goals_canceling)

    def _hear(self, message: Any) -> None:
        heard = self._heard.get(bytes(message.goal_id.uuid))
        if heard is not None:
            heard(message.feedback)

    def _over(self, goal: SentGoal, response: Any) -> None:
        self._feedback.work()  # what came before the result is heard before it
        self._heard.pop(goal.id, None)
        goal.result = response.result
        goal.state = GoalState(response.status)
