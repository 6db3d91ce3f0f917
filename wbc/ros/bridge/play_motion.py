"""The action that plays a motion: `play_motion2`, of the type that PAL Robotics' robots have.

A type that is there already and not one of ours, so clients exist. `motion_name` is a name, then
parameters: `squat`, `squat depth=15 times=2`. `skip_planning` is not used: a motion without its
plan could not be played.
"""

from __future__ import annotations

import logging
from typing import Any

from wbc.errors import MotionError
from wbc.messages import message_type
from wbc.motions import Motion
from wbc.motions.engine import parse_motion
from wbc.ros.actions import ActionServer, GoalStatus, ServerGoalHandle
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.navigate_to_pose import NavigateToPose
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.rate_limiter import RateLimiter
from wbc.ros.stamp import stamp_from_seconds
from wbc.runtime.mode import Mode
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    MotionCommand,
    StandCommand,
)

logger = logging.getLogger(__name__)

NAME = "play_motion2"
TYPE = "play_motion2_msgs/action/PlayMotion2"
_LIST = "play_motion2_msgs/srv/ListMotions"
_READY = "play_motion2_msgs/srv/IsMotionReady"
_FEEDBACK_RATE = 5.0  # Hz


class PlayMotion:
    """Serves the action, and the two services that go with it.

    A goal is over when the robot stands again; when it is cancelled, or when its client is gone,
    the robot stops first. Another goal takes its place, and so does walking.

    Args:
        node: serves the action.
        client: plans the motions and sends the commands.
        cmd_vel: stops when a motion begins.
        navigate: its goal is aborted when a motion begins.
    """

    def __init__(
        self, node: Node, client: CommandClient, cmd_vel: CmdVel, navigate: NavigateToPose
    ) -> None:
        self._client, self._cmd_vel, self._navigate = client, cmd_vel, navigate
        client.on_motion_sent = self._on_motion_sent
        self._motions = client.capabilities.motions
        self._server = ActionServer(
            node,
            TYPE,
            NAME,
            goal_callback=self._accept,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        self._list = message_type(f"{_LIST}_Response")(motion_keys=[m.name for m in self._motions])
        node.create_service(_LIST, f"{NAME}/list_motions", lambda *_: self._list)
        node.create_service(_READY, f"{NAME}/is_motion_ready", self._is_ready)
        self._feedback_due = RateLimiter(_FEEDBACK_RATE)
        self._tick: StampedTick | None = None
        self._goal: ServerGoalHandle | None = None
        self._command = 0  # number of the goal's command
        self._sent = False  # the goal's motion is in the loop, no longer being planned
        self._orphaned = False  # the loop plays the motion of an earlier goal
        self._ending: tuple[GoalStatus, str] | None = None

    def take(self, tick: StampedTick) -> None:
        """Take a tick of the loop."""
        before, self._tick = self._tick, tick
        goal = self._goal
        if goal is None:
            return
        if before is not None and tick.run != before.run:
            self.abort("the robot was reset")
        elif tick.mode is Mode.FALLEN:
            self.abort("the robot fell")
        elif self._sent and self._ending is None and not goal.client_alive:
            self._stop_motion(GoalStatus.ABORTED, "the client of the goal has disconnected")
        elif self._sent and self._feedback_due.is_due(tick.stamp):
            feedback: Any = self._server.feedback_type(current_time=stamp_from_seconds(tick.stamp))
            goal.publish_feedback(feedback)

    def on_acknowledgement(self, acknowledgement: Acknowledgement) -> None:
        """End the goal when its motion is over."""
        if self._goal is None or acknowledgement.id != self._command:
            return
        reason = acknowledgement.reason
        match acknowledgement.outcome:
            case CommandOutcome.DONE:
                self._finish(GoalStatus.SUCCEEDED, "")
            case CommandOutcome.ABORTED:
                self._finish(GoalStatus.ABORTED, f"the robot gave up the motion: {reason}")
            case CommandOutcome.SUPERSEDED:
                self._finish(*(self._ending or (GoalStatus.ABORTED, reason)))
            case CommandOutcome.REFUSED:
                self._finish_unsent(GoalStatus.ABORTED, reason)

    def abort(self, reason: str) -> None:
        """Abort the goal in progress, if there is one."""
        if self._goal is not None:
            self._finish(GoalStatus.ABORTED, reason)

    def _is_ready(self, request: Any, response: Any) -> Any:
        """Return whether a goal with this text would be accepted now."""
        try:
            parse_motion(request.motion_key, self._motions)
        except MotionError:
            return response
        response.is_ready = self._accept(request)
        return response

    def _accept(self, _: Any) -> bool:
        return self._tick is not None and self._tick.mode is Mode.RUNNING

    def _begin(self, goal: ServerGoalHandle) -> None:
        try:
            command = MotionCommand(parse_motion(goal.request.motion_name, self._motions))
        except MotionError as error:  # the motion in progress goes on
            goal.finish(GoalStatus.ABORTED, self._server.result_type(error=str(error)))
            return
        self._orphaned = self._goal is not None and (self._sent or self._orphaned)
        self.abort("superseded by another goal")
        self._goal, self._sent, self._ending = goal, False, None
        try:
            self._command = self._client.send(command)
        except CommandRefused as error:
            self._finish_unsent(GoalStatus.ABORTED, str(error))

    def _on_motion_sent(self, motion: Motion) -> None:
        self._sent, self._orphaned = True, False
        if not motion.while_walking:
            self._navigate.abort("superseded by a motion")
            self._cmd_vel.stand()
        logger.info("%s: %s", NAME, motion.name)

    def _cancel(self, goal: ServerGoalHandle) -> bool:
        if goal is not self._goal:
            return False
        if self._sent:
            self._stop_motion(GoalStatus.CANCELED, "cancelled")
        else:
            self._finish_unsent(GoalStatus.CANCELED, "cancelled")
        return True

    def _finish_unsent(self, state: GoalStatus, error: str) -> None:
        """End a goal whose motion never reached the loop, and the motion that it superseded."""
        self._finish(state, error)
        if self._orphaned:
            self._stand()

    def _stop_motion(self, state: GoalStatus, error: str) -> None:
        """Stop the motion; the goal is over when the robot stands."""
        self._ending = (state, error)
        self._stand()

    def _stand(self) -> None:
        try:
            self._client.send(StandCommand())
        except CommandRefused as error:
            logger.warning("%s: %s", NAME, error)

    def _finish(self, state: GoalStatus, error: str) -> None:
        goal, self._goal = self._goal, None
        assert goal is not None
        if not self._sent:
            self._client.cancel_planning()
        succeeded = state is GoalStatus.SUCCEEDED
        logger.info("%s %s: %s", NAME, goal.request.motion_name, error or "done")
        goal.finish(state, self._server.result_type(success=succeeded, error=error))
