"""The base of the robot's actions, which have at most one goal in progress."""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from typing import Any

from wbc.messages import Message
from wbc.ros.actions import ActionServer, GoalStatus, ServerGoalHandle
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.runtime.mode import Mode
from wbc.runtime.rate_limiter import RateLimiter
from wbc.teleop import CommandRefused

logger = logging.getLogger(__name__)

_UPDATE_RATE = 20.0  # Hz
_FEEDBACK_RATE = 5.0  # Hz


class RobotAction(ABC):
    """Serves an action of the robot.

    A goal ends when the robot stands: the robot is stopped first when the goal is cancelled or its
    client leaves the graph. A new goal, a fall and a reset abort the goal at once. Why a goal is
    rejected is logged, since the answer to a rejected goal has no place for a reason.

    Args:
        node: node that serves the action.
        action_type: `pkg/action/Name`.
        name: name of the action.
    """

    def __init__(self, node: Node, action_type: str, name: str) -> None:
        self._name = name
        self._server = ActionServer(
            node,
            action_type,
            name,
            goal_callback=self._is_acceptable,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=self._on_cancel,
        )
        self._update_limiter = RateLimiter(_UPDATE_RATE)
        self._feedback_limiter = RateLimiter(_FEEDBACK_RATE)
        self._tick: StampedTick | None = None
        self._goal: ServerGoalHandle | None = None
        # Status and text with which the goal ends as soon as the robot stands.
        self._outcome: tuple[GoalStatus, str] | None = None

    @abstractmethod
    def _start(self, goal: Any, tick: StampedTick) -> None:
        """Begin to pursue a goal, given its message and the latest tick."""

    @abstractmethod
    def _stop_robot(self) -> None:
        """Stop the robot because `_outcome` is decided; `_finish` is called when it stands."""

    @abstractmethod
    def _result(self, status: GoalStatus, text: str) -> Message:
        """Return the message of the result; the text is empty if the goal succeeded."""

    @abstractmethod
    def _feedback(self, tick: StampedTick) -> Message:
        """Return the message of the feedback."""

    def _update(self, goal: ServerGoalHandle, tick: StampedTick) -> None:
        """Pursue the goal in progress; called 20 times per second."""
        if self._feedback_limiter.is_due(tick.stamp):
            goal.publish_feedback(self._feedback(tick))
        if self._outcome is None and not goal.client_alive:
            self._stop(GoalStatus.ABORTED, "the client of the goal has disconnected")

    def on_tick(self, tick: StampedTick) -> None:
        """Process a tick of the loop."""
        previous, self._tick = self._tick, tick
        goal = self._goal
        if goal is None:
            return
        if previous is not None and tick.run != previous.run:
            self.abort("the robot was reset")
        elif tick.mode is Mode.FALLEN:
            self.abort("the robot fell")
        elif self._update_limiter.is_due(tick.stamp):
            self._update(goal, tick)

    def abort(self, reason: str) -> None:
        """Abort the goal in progress, if there is one, without waiting until the robot stands."""
        if self._goal is not None:
            self._finish(GoalStatus.ABORTED, reason)

    def _is_acceptable(self, goal: Any) -> bool:
        """Return whether a goal, given its message, can be accepted now; log why it cannot."""
        try:
            self._check(goal)
        except CommandRefused as error:
            logger.warning("%s: rejected a goal: %s", self._name, error)
            return False
        return True

    def _check(self, _: Any) -> None:
        """Check that a goal, given its message, can be accepted now.

        Raises:
            CommandRefused: it cannot; the text is the reason.
        """
        match self._tick and self._tick.mode:
            case None:
                raise CommandRefused("the robot's loop has not started")
            case Mode.FALLEN:
                raise CommandRefused("the robot has fallen; call reset_robot")
            case Mode.PAUSED:
                raise CommandRefused("the robot's loop is paused")

    def _on_accepted(self, goal: ServerGoalHandle) -> None:
        self.abort("superseded by another goal")
        self._goal, self._outcome = goal, None
        assert self._tick is not None
        self._start(goal.request, self._tick)

    def _on_cancel(self, goal: ServerGoalHandle) -> bool:
        if goal is not self._goal:
            return False
        self._stop(GoalStatus.CANCELED, "cancelled")
        return True

    def _stop(self, status: GoalStatus, text: str) -> None:
        """Stop the robot, and finish the goal with this outcome when it stands."""
        self._outcome = (status, text)
        self._stop_robot()

    def _finish(self, status: GoalStatus, text: str = "") -> None:
        goal, self._goal, self._outcome = self._goal, None, None
        assert goal is not None
        logger.info("%s: %s", self._name, text or status.name.lower())
        goal.finish(status, self._result(status, text))
