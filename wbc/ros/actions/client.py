"""Action clients."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from wbc.messages import Message, message_type
from wbc.ros.actions.goal_status import GoalStatus
from wbc.ros.actions.server import CANCEL_SERVICE
from wbc.ros.errors import ResponseTimeout

if TYPE_CHECKING:
    from wbc.ros.node import Node


class ClientGoalHandle:
    """A goal on the side of the client.

    Attributes:
        goal_id: 16 bytes.
        accepted: whether the server accepted the goal.
        status: UNKNOWN until the goal is finished, then its terminal status.
        result: message of the result once the goal is finished, otherwise None.
    """

    def __init__(self, client: ActionClient, goal_id: bytes) -> None:
        self._client = client
        self.goal_id = goal_id
        self.accepted = False
        self.status = GoalStatus.UNKNOWN
        self.result: Any = None

    def cancel_goal(self, timeout_sec: float = 5.0) -> bool:
        """Ask the server to cancel the goal; return whether it agreed.

        Raises:
            ResponseTimeout: the server did not respond in time.
        """
        client = self._client.cancel_client
        request = client.request_type()
        request.goal_info.goal_id.uuid = list(self.goal_id)
        response = client.call(request, timeout_sec)
        return any(bytes(info.goal_id.uuid) == self.goal_id for info in response.goals_canceling)

    def wait_for_result(self, timeout_sec: float) -> bool:
        """Spin the node until the goal is finished; return whether it is."""
        return self._client.node.spin_until(lambda: self.status.terminal, timeout_sec)


class ActionClient:
    """Sends goals to an action server.

    Args:
        node: the node.
        action_type: `pkg/action/Name`.
        action_name: name of the action.

    Attributes:
        node: the node.
        action_name: fully qualified name of the action.
        goal_type: class of the goals.
        cancel_client: client of the service that cancels goals.
    """

    def __init__(self, node: Node, action_type: str, action_name: str) -> None:
        self.node = node
        self.action_name = node.resolve_topic_name(action_name)
        self.goal_type = message_type(f"{action_type}_Goal")
        prefix = f"{self.action_name}/_action"
        self._callbacks: dict[bytes, Callable[[Any], None]] = {}  # of feedback, by goal
        self._feedback = node.create_subscription(
            f"{action_type}_FeedbackMessage", f"{prefix}/feedback", self._on_feedback
        )
        self._send = node.create_client(f"{action_type}_SendGoal", f"{prefix}/send_goal")
        self.cancel_client = node.create_client(CANCEL_SERVICE, f"{prefix}/cancel_goal")
        self._result = node.create_client(f"{action_type}_GetResult", f"{prefix}/get_result")

    def server_is_ready(self) -> bool:
        """Return whether there is a server for the action."""
        return all(c.service_is_ready() for c in (self._send, self.cancel_client, self._result))

    def wait_for_server(self, timeout_sec: float) -> bool:
        """Spin the node until there is a server for the action; return whether there is."""
        return self.node.spin_until(self.server_is_ready, timeout_sec)

    def send_goal(
        self,
        goal: Message,
        feedback_callback: Callable[[Any], None] = lambda _: None,
        timeout_sec: float = 5.0,
    ) -> ClientGoalHandle:
        """Send a goal and spin the node until the server accepts or rejects it.

        The result arrives later, while the node spins: see `ClientGoalHandle.wait_for_result`.

        Args:
            goal: message of the goal, of class `goal_type`.
            feedback_callback: called with the feedback.
            timeout_sec: time limit, s.

        Raises:
            ResponseTimeout: there is no server, or it did not respond in time.
        """
        if not self.wait_for_server(timeout_sec):
            raise ResponseTimeout(f"there is no server for the action {self.action_name}")
        future = self.send_goal_async(goal, feedback_callback)
        if not self.node.spin_until(future.done, timeout_sec):
            raise ResponseTimeout(f"{self.action_name} did not respond in {timeout_sec:g} s")
        return future.result()

    def send_goal_async(
        self, goal: Message, feedback_callback: Callable[[Any], None] = lambda _: None
    ) -> Future[ClientGoalHandle]:
        """Send a goal; see `send_goal`.

        Returns:
            The future handle of the goal, which arrives while the node spins.
        """
        answered: Future[ClientGoalHandle] = Future()
        handle = ClientGoalHandle(self, uuid.uuid4().bytes)
        request = self._send.request_type(goal=goal)
        request.goal_id.uuid = list(handle.goal_id)
        self._callbacks[handle.goal_id] = feedback_callback

        def on_answer(future: Future[Any]) -> None:
            handle.accepted = bool(future.result().accepted)
            if handle.accepted:
                request = self._result.request_type()
                request.goal_id.uuid = list(handle.goal_id)
                result = self._result.call_async(request)
                result.add_done_callback(lambda done: self._on_result(handle, done))
            else:
                del self._callbacks[handle.goal_id]
            answered.set_result(handle)

        self._send.call_async(request).add_done_callback(on_answer)
        return answered

    def _on_feedback(self, message: Any) -> None:
        callback = self._callbacks.get(bytes(message.goal_id.uuid))
        if callback is not None:
            callback(message.feedback)

    def _on_result(self, handle: ClientGoalHandle, future: Future[Any]) -> None:
        self._feedback.execute()  # deliver the feedback that arrived before the result
        self._callbacks.pop(handle.goal_id, None)
        response = future.result()
        handle.result = response.result
        handle.status = GoalStatus(response.status)
