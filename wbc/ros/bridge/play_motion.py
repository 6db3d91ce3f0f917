"""The action `play_motion2`, which plays a motion, of the type that PAL Robotics defines.

An existing type is used so that existing clients work. `motion_name` is the name of a motion,
followed by parameters: `squat`, `squat depth=15 times=2`. The field `skip_planning` is ignored,
because a motion cannot be played without its plan.
"""

from __future__ import annotations

import logging
from typing import Any

from wbc.errors import MotionError
from wbc.messages import Message, message_type
from wbc.motions import Motion
from wbc.motions.engine import parse_motion
from wbc.ros.actions import GoalStatus, ServerGoalHandle
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.navigate_to_pose import NavigateToPose
from wbc.ros.bridge.robot_action import RobotAction
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.stamp import stamp_from_seconds
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


class PlayMotion(RobotAction):
    """Serves the action and the services `list_motions` and `is_motion_ready`.

    A goal succeeds when the motion is over and the robot stands. Walking aborts the goal, unless
    the motion can be played while walking.

    Args:
        node: node that serves the action.
        client: plans the motions and sends the commands.
        cmd_vel: stops walking when a motion begins.
        navigate: its goal is aborted when a motion begins.
    """

    def __init__(
        self, node: Node, client: CommandClient, cmd_vel: CmdVel, navigate: NavigateToPose
    ) -> None:
        super().__init__(node, TYPE, NAME)
        self._client, self._cmd_vel, self._navigate = client, cmd_vel, navigate
        client.on_motion_sent = self._on_motion_sent
        self._motions = client.capabilities.motions
        names = message_type(f"{_LIST}_Response")(motion_keys=[m.name for m in self._motions])
        node.create_service(_LIST, f"{NAME}/list_motions", lambda *_: names)
        node.create_service(_READY, f"{NAME}/is_motion_ready", self._is_motion_ready)
        self._command_id = 0  # of the goal's command
        self._sent = False  # whether the goal's motion has been planned and sent to the loop
        self._previous_plays = False  # whether the loop still plays the motion of an earlier goal

    def on_acknowledgement(self, acknowledgement: Acknowledgement) -> None:
        """Finish the goal if its command is the one that is acknowledged as over."""
        if self._goal is None or acknowledgement.id != self._command_id:
            return
        reason = acknowledgement.reason
        match acknowledgement.outcome:
            case CommandOutcome.DONE:
                self._finish(GoalStatus.SUCCEEDED)
            case CommandOutcome.ABORTED:
                self._finish(GoalStatus.ABORTED, f"the robot gave up the motion: {reason}")
            case CommandOutcome.SUPERSEDED:
                self._finish(*(self._outcome or (GoalStatus.ABORTED, reason)))
            case CommandOutcome.REFUSED:
                self._sent = False
                self._stop(GoalStatus.ABORTED, reason)

    def _is_motion_ready(self, request: Any, response: Any) -> Any:
        try:
            parse_motion(request.motion_key, self._motions)
            self._check(request)
        except (MotionError, CommandRefused):
            return response
        response.is_ready = True
        return response

    def _on_accepted(self, goal: ServerGoalHandle) -> None:
        try:
            parse_motion(goal.request.motion_name, self._motions)
        except MotionError as error:  # the motion in progress goes on
            goal.finish(GoalStatus.ABORTED, self._result(GoalStatus.ABORTED, str(error)))
            return
        self._previous_plays = self._goal is not None and (self._sent or self._previous_plays)
        super()._on_accepted(goal)

    def _start(self, goal: Any, tick: StampedTick) -> None:
        self._sent = False
        try:
            motion = parse_motion(goal.motion_name, self._motions)
            self._command_id = self._client.send(MotionCommand(motion))
        except CommandRefused as error:
            self._stop(GoalStatus.ABORTED, str(error))

    def _on_motion_sent(self, motion: Motion) -> None:
        self._sent, self._previous_plays = True, False
        if not motion.while_walking:
            self._navigate.abort("superseded by a motion")
            self._cmd_vel.stand()
        logger.info("%s: playing %s", NAME, motion.name)

    def _stop_robot(self) -> None:
        if self._sent or self._previous_plays:
            try:
                self._client.send(StandCommand())
            except CommandRefused as error:
                logger.warning("%s: %s", NAME, error)
        if not self._sent:  # no acknowledgement will follow
            assert self._outcome is not None
            self._finish(*self._outcome)

    def _finish(self, status: GoalStatus, text: str = "") -> None:
        if not self._sent:
            self._client.cancel_planning()
        super()._finish(status, text)

    def _result(self, status: GoalStatus, text: str) -> Message:
        return self._server.result_type(success=status is GoalStatus.SUCCEEDED, error=text)

    def _feedback(self, tick: StampedTick) -> Message:
        return self._server.feedback_type(current_time=stamp_from_seconds(tick.stamp))
