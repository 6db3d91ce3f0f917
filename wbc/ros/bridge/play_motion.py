"""The action that plays a motion: `play_motion2`, of the type that PAL Robotics' robots have.

A type that is there already and not one of ours, so clients exist. `motion_name` is a name, then
parameters: `squat`, `squat depth=15 times=2`. `skip_planning` is not used: a motion without its
plan could not be played.
"""

from __future__ import annotations

import logging
import queue
from typing import Any

from wbc.errors import MotionError
from wbc.messages import message_type
from wbc.motions import Motion
from wbc.motions.engine.blob_buffer import BlobBuffer
from wbc.motions.engine.manager import MotionStatus
from wbc.motions.engine.parsing import parse_motion
from wbc.motions.engine.planning import MotionPlanner, PlannedMotion
from wbc.ros.actions import ActionServer, GoalStatus, ServerGoalHandle
from wbc.ros.bridge.layout import Mode, Sample
from wbc.ros.bridge.mailbox import Mailbox, Orders
from wbc.ros.bridge.order import Order
from wbc.ros.bridge.slip import Slip
from wbc.ros.bridge.steering import Steering
from wbc.ros.bridge.walk_to import WalkTo
from wbc.ros.node import Node
from wbc.ros.rate_limiter import RateLimiter
from wbc.ros.stamp import stamp_from_seconds

logger = logging.getLogger(__name__)

NAME = "play_motion2"
TYPE = "play_motion2_msgs/action/PlayMotion2"
_LIST = "play_motion2_msgs/srv/ListMotions"
_READY = "play_motion2_msgs/srv/IsMotionReady"
_LOOK = 0.02  # s between two looks for what has been planned
_FEEDBACK_RATE = 5.0  # Hz


class PlayMotion:
    """Serves the action, and the services that tell which motions there are.

    Motions are checked and planned here, where nobody waits for a tick. A goal is over when the
    robot is back to standing, also when it is cancelled or who sent it has gone. Like every
    order, it takes the place of the one before.
    """

    def __init__(
        self,
        node: Node,
        steering: Steering,
        walk_to: WalkTo,
        orders: Orders,
        mailbox: Mailbox,
        order: Order,
    ) -> None:
        self._steering, self._walk_to = steering, walk_to
        self._orders, self._mailbox = orders, mailbox
        self._motions = order.motions
        self._shelf, self._slip = BlobBuffer(order.shelf), Slip(order.slip)
        self._plans: queue.SimpleQueue[PlannedMotion] = queue.SimpleQueue()
        self._planner = MotionPlanner(order.robot, (), self._plans.put)
        self._planner.start()
        self._server = ActionServer(
            node,
            TYPE,
            NAME,
            goal_callback=self._accept,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        self._listed = message_type(f"{_LIST}_Response")(
            motion_keys=[m.name for m in order.motions]
        )
        node.create_service(_LIST, f"{NAME}/list_motions", lambda *_: self._listed)
        node.create_service(_READY, f"{NAME}/is_motion_ready", self._is_ready)
        node.create_timer(_LOOK, self._look)
        self._tells = RateLimiter(_FEEDBACK_RATE)
        self._sample: Sample | None = None
        self._goal: ServerGoalHandle | None = None
        self._motion: Motion | None = None  # of the goal, while it is being planned
        self._orphaned = False  # the loop plays what belongs to an earlier goal
        self._ending: tuple[GoalStatus, str] | None = None
        steering.sets_out = self._forget

    def take(self, sample: Sample) -> None:
        """One tick more."""
        before, self._sample = self._sample, sample
        goal = self._goal
        if goal is None:
            return
        if before is not None and sample.run != before.run:
            self.stop("the robot was reset")
        elif sample.mode is Mode.FALLEN:
            self.stop("the robot fell")
        elif self._motion is None and sample.motions == self._orders.motions:
            self._follow(goal, sample)

    def stop(self, why: str) -> None:
        """End the goal that is pursued, if there is one."""
        if self._goal is not None:
            self._finish(GoalStatus.ABORTED, why)

    def _is_ready(self, request: Any, response: Any) -> Any:
        """Whether a goal would be begun now, as far as its text goes."""
        try:
            parse_motion(request.motion_key, self._motions)
        except MotionError:
            return response
        response.is_ready = self._accept(request)
        return response

    def _accept(self, _: Any) -> bool:
        return self._sample is not None and self._sample.mode is Mode.RUNNING

    def _begin(self, goal: ServerGoalHandle) -> None:
        try:
            motion = parse_motion(goal.request.motion_name, self._motions)
        except MotionError as error:  # what goes on goes on
            goal.finish(GoalStatus.ABORTED, self._server.result_type(error=str(error)))
            return
        self._orphaned = self._goal is not None and (self._motion is None or self._orphaned)
        self.stop("another goal took its place")
        self._goal, self._motion, self._ending = goal, motion, None
        self._planner.request(motion)

    def _look(self) -> None:
        """Have the loop play what has been planned."""
        while not self._plans.empty():
            plan = self._plans.get()
            if plan.motion == self._motion:
                self._order(plan)

    def _order(self, plan: PlannedMotion) -> None:
        try:
            if plan.error:
                raise MotionError(plan.error)
            slot = self._shelf.write(plan.packed)
        except MotionError as error:
            self._drop(GoalStatus.ABORTED, str(error))
            return
        if not plan.motion.while_walking:
            self._walk_to.stop("a motion took its place")
            self._steering.stand()
        orders = self._orders
        orders.motions, orders.slot, orders.size = orders.motions + 1, slot, len(plan.packed)
        self._mailbox.post(orders)
        self._motion = None
        logger.info("%s: %s", NAME, plan.motion.name)

    def _forget(self) -> None:
        """The robot is to walk: a motion that is being planned comes too late for it."""
        if self._motion is not None and not self._motion.while_walking:
            self._drop(GoalStatus.ABORTED, "the robot was told to walk")

    def _cancel(self, goal: ServerGoalHandle) -> bool:
        if goal is not self._goal:
            return False
        if self._motion is None:
            self._leave_off(GoalStatus.CANCELED, "cancelled")
        else:
            self._drop(GoalStatus.CANCELED, "cancelled")
        return True

    def _drop(self, state: GoalStatus, why: str) -> None:
        """End a goal that has not come to the loop; what it has taken the place of ends too."""
        self._finish(state, why)
        if self._orphaned:
            self._stand()

    def _leave_off(self, state: GoalStatus, why: str) -> None:
        """Come to a stand; then the goal is over."""
        self._ending = (state, why)
        self._stand()

    def _stand(self) -> None:
        self._orders.stands += 1
        self._mailbox.post(self._orders)

    def _follow(self, goal: ServerGoalHandle, sample: Sample) -> None:
        """See what the loop makes of it."""
        if sample.stage is MotionStatus.DONE:
            self._finish(GoalStatus.SUCCEEDED, "")
        elif sample.stage is MotionStatus.ABORTED:
            why = self._slip.read(sample.motions)
            self._finish(GoalStatus.ABORTED, f"the robot gave it up: {why}")
        elif sample.stage is MotionStatus.CANCELED:
            self._finish(
                *(self._ending or (GoalStatus.ABORTED, "it was left off for another order"))
            )
        elif self._ending is None and not goal.client_alive:
            self._leave_off(GoalStatus.ABORTED, "who sent the goal has gone")
        elif self._tells.is_due(sample.stamp):
            feedback: Any = self._server.feedback_type(
                current_time=stamp_from_seconds(sample.stamp)
            )
            goal.publish_feedback(feedback)

    def _finish(self, state: GoalStatus, error: str) -> None:
        goal, self._goal, self._motion = self._goal, None, None
        assert goal is not None
        self._planner.request(None)
        done = state is GoalStatus.SUCCEEDED
        logger.info("%s %s: %s", NAME, goal.request.motion_name, error or "done")
        goal.finish(state, self._server.result_type(success=done, error=error))
