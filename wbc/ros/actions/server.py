"""Action servers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, message_type
from wbc.ros.actions.goal_status import GoalStatus
from wbc.ros.qos import LATCHED
from wbc.ros.stamp import stamp_now

if TYPE_CHECKING:
    from wbc.ros.node import Node
    from wbc.ros.services import ServiceReply

CANCEL_SERVICE = "action_msgs/srv/CancelGoal"
_GOAL_INFO = message_type("action_msgs/msg/GoalInfo")
_STATUS = message_type("action_msgs/msg/GoalStatus")
_STATUS_ARRAY = message_type("action_msgs/msg/GoalStatusArray")
_RESULT_TIMEOUT = 60.0  # s for which the result of a finished goal is kept


class ServerGoalHandle:
    """A goal on the side of the server.

    Attributes:
        goal_id: 16 bytes.
        request: message of the goal.
        status: status of the goal.
        info: the goal's id and time of acceptance, as `GoalInfo`.
        result: message of the result once the goal is finished, otherwise None.
        finished_at: time at which it was finished, s on the monotonic clock; infinite before.
        pending: requests for the result that wait until the goal is finished.
    """

    def __init__(
        self, server: ActionServer, goal_id: bytes, request: Any, reply: ServiceReply
    ) -> None:
        self._server, self._reply = server, reply
        self.goal_id, self.request = goal_id, request
        self.status = GoalStatus.ACCEPTED
        self.info = _GOAL_INFO(stamp=stamp_now())
        self.info.goal_id.uuid = list(goal_id)
        self.result: Message | None = None
        self.finished_at = float("inf")
        self.pending: list[ServiceReply] = []

    @property
    def client_alive(self) -> bool:
        """Whether the client that sent the goal is still in the graph."""
        return self._reply.client_alive

    def publish_feedback(self, feedback: Message) -> None:
        """Publish feedback."""
        publisher = self._server.feedback_publisher
        publisher.publish(publisher.msg_type(goal_id=self.info.goal_id, feedback=feedback))

    def finish(self, status: GoalStatus, result: Message) -> None:
        """Finish the goal as SUCCEEDED, CANCELED or ABORTED; ignored if it is finished."""
        if self.status.terminal:
            return
        self.status, self.result, self.finished_at = status, result, time.monotonic()
        self._server.publish_status()
        for reply in self.pending:
            self.send_result(reply)

    def send_result(self, reply: ServiceReply) -> None:
        """Respond to a request for the result as soon as the goal is finished."""
        if self.result is None:
            self.pending.append(reply)
        else:
            response_type = reply.service.response_type
            reply.send(response_type(status=self.status, result=self.result))


class ActionServer:
    """Serves an action.

    Args:
        node: the node.
        action_type: `pkg/action/Name`.
        action_name: name of the action.
        goal_callback: called with the message of a goal; returns whether to accept it.
        handle_accepted_callback: called with the handle of each accepted goal, whose status is
            EXECUTING from then on; it must be finished by `ServerGoalHandle.finish`.
        cancel_callback: called with the handle of a goal to cancel; returns whether to accept
            that. The goal is CANCELING from then on and must still be finished.

    Attributes:
        goal_type: class of the goals.
        result_type: class of the results.
        feedback_type: class of the feedback.
        feedback_publisher: publisher of the feedback.
        goals: handles of the known goals, by id.
    """

    def __init__(
        self,
        node: Node,
        action_type: str,
        action_name: str,
        *,
        goal_callback: Callable[[Any], bool],
        handle_accepted_callback: Callable[[ServerGoalHandle], None],
        cancel_callback: Callable[[ServerGoalHandle], bool],
    ) -> None:
        self._goal_callback = goal_callback
        self._handle_accepted_callback = handle_accepted_callback
        self._cancel_callback = cancel_callback
        self.goal_type = message_type(f"{action_type}_Goal")
        self.result_type = message_type(f"{action_type}_Result")
        self.feedback_type = message_type(f"{action_type}_Feedback")
        self.goals: dict[bytes, ServerGoalHandle] = {}
        prefix = f"{node.resolve_topic_name(action_name)}/_action"
        node.create_deferred_service(
            f"{action_type}_SendGoal", f"{prefix}/send_goal", self._on_goal
        )
        node.create_service(CANCEL_SERVICE, f"{prefix}/cancel_goal", self._on_cancel)
        node.create_deferred_service(
            f"{action_type}_GetResult", f"{prefix}/get_result", self._on_result
        )
        self.feedback_publisher = node.create_publisher(
            f"{action_type}_FeedbackMessage", f"{prefix}/feedback"
        )
        self._status = node.create_publisher(_STATUS_ARRAY, f"{prefix}/status", LATCHED)
        self.publish_status()

    def _on_goal(self, request: Any, reply: ServiceReply) -> None:
        goal_id = bytes(request.goal_id.uuid)
        self._remove_expired()
        accepted = goal_id not in self.goals and self._goal_callback(request.goal)
        reply.send(reply.service.response_type(accepted=accepted, stamp=stamp_now()))
        if not accepted:
            return
        goal = self.goals[goal_id] = ServerGoalHandle(self, goal_id, request.goal, reply)
        goal.status = GoalStatus.EXECUTING
        self.publish_status()
        self._handle_accepted_callback(goal)

    def _on_result(self, request: Any, reply: ServiceReply) -> None:
        goal = self.goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            reply.send(reply.service.response_type(status=GoalStatus.UNKNOWN))
        else:
            goal.send_result(reply)

    def _on_cancel(self, request: Any, response: Any) -> Any:
        """Cancel all goals, one goal, or those accepted before some time; see `CancelGoal`."""
        goal_id, stamp = bytes(request.goal_info.goal_id.uuid), request.goal_info.stamp
        has_id, has_stamp = any(goal_id), (stamp.sec, stamp.nanosec) != (0, 0)
        if has_id and goal_id not in self.goals:
            response.return_code = response.ERROR_UNKNOWN_GOAL_ID
            return response
        if has_id and not has_stamp and self.goals[goal_id].status.terminal:
            response.return_code = response.ERROR_GOAL_TERMINATED
            return response
        for goal in tuple(self.goals.values()):
            accepted = goal.info.stamp
            is_earlier = (accepted.sec, accepted.nanosec) <= (stamp.sec, stamp.nanosec)
            selected = goal.goal_id == goal_id or (is_earlier if has_stamp else not has_id)
            if selected and not goal.status.terminal and self._cancel_callback(goal):
                if not goal.status.terminal:
                    goal.status = GoalStatus.CANCELING
                response.goals_canceling.append(goal.info)
        self.publish_status()
        if not response.goals_canceling:
            response.return_code = response.ERROR_REJECTED
        return response

    def _remove_expired(self) -> None:
        oldest = time.monotonic() - _RESULT_TIMEOUT
        self.goals = {key: goal for key, goal in self.goals.items() if goal.finished_at > oldest}

    def publish_status(self) -> None:
        """Publish the status of all goals."""
        goals = self.goals.values()
        self._status.publish(
            _STATUS_ARRAY(status_list=[_STATUS(goal_info=g.info, status=g.status) for g in goals])
        )
