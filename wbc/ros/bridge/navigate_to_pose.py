"""The action that walks to a pose: `navigate_to_pose`, of the type that Nav2 has.

Nav2's own type and not one of ours: RViz's goal tool, `ros2 action` and every client written for
Nav2 can send it, and nothing has to be built on the ROS side. Later releases of Nav2 appended
fields, which earlier readers do not mind. `behavior_tree` is not used.
"""

from __future__ import annotations

import logging
import math
from typing import Any

import numpy as np

from wbc.robot import Robot
from wbc.robot.attitude import heading
from wbc.ros.actions import ActionServer, GoalStatus, ServerGoalHandle
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.pose_controller import PlanarPose, PoseController
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.rate_limiter import RateLimiter
from wbc.ros.stamp import duration_from_seconds, stamp_from_seconds
from wbc.runtime.mode import Mode
from wbc.runtime.schema import ODOM
from wbc.state import State

logger = logging.getLogger(__name__)

TYPE = "nav2_msgs/action/NavigateToPose"
_ODOM_FRAMES = ("", ODOM, "map", "world")
_BASE_FRAMES = ("base_link", "base_footprint")  # and the robot's own name for its base
_RATE = 20.0  # Hz, of the steering
_FEEDBACK_RATE = 5.0  # Hz
_VELOCITY_TIMEOUT = 0.5  # s after which the robot stops when no velocity follows
_STANDING_TIME = 0.3  # s of standing before it counts
_NEAR = 0.8  # m: it steps there in any direction
_GAIN = 0.6  # 1/s
_STUCK_TIMEOUT = 20.0  # s without coming nearer
_MIN_PROGRESS = 0.03  # m that count as coming nearer
_MAX_CORRECTIONS = 5  # of a robot that stopped beside the goal
_UNKNOWN_ERROR, _TIMEOUT = 9000, 9003


class NavigateToPose:
    """Serves the action.

    A goal is over when the robot stands at it; when it is cancelled, or when its client is gone,
    the robot stops first.

    Args:
        node: serves the action.
        cmd_vel: sends the velocities.
        robot: the robot.
    """

    def __init__(self, node: Node, cmd_vel: CmdVel, robot: Robot) -> None:
        self._cmd_vel, self._robot = cmd_vel, robot
        self._speed_share = node.declare_parameter(
            "walk_speed", 0.6, "speed of walking to a pose, share of the gait's largest velocity",
            minimum=0.1, maximum=1.0,
        )  # fmt: skip
        self._tolerance = node.declare_parameter(
            "position_tolerance",
            0.1,
            "position tolerance of walking to a pose, m",
            minimum=0.02,
            maximum=1.0,
        )
        self._heading_tolerance = node.declare_parameter(
            "heading_tolerance",
            0.15,
            "heading tolerance of walking to a pose, rad",
            minimum=0.05,
            maximum=math.pi,
        )
        self._server = ActionServer(
            node,
            TYPE,
            "navigate_to_pose",
            goal_callback=self._accept,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        self._control_due, self._feedback_due = RateLimiter(_RATE), RateLimiter(_FEEDBACK_RATE)
        self._tick: StampedTick | None = None
        self._goal: ServerGoalHandle | None = None
        self._target = PlanarPose(0.0, 0.0, 0.0)
        self._ending: tuple[GoalStatus, Any] | None = None
        cmd_vel.on_override = lambda: self.abort("cmd_vel took over")

    def take(self, tick: StampedTick) -> None:
        """Take a tick of the loop."""
        before, self._tick = self._tick, tick
        if self._goal is None:
            return
        if before is not None and tick.run != before.run:
            self.abort("the robot was reset")
        elif tick.mode is Mode.FALLEN:
            self.abort("the robot fell")
        elif self._control_due.is_due(tick.stamp):
            self._advance(self._goal, tick)

    def abort(self, reason: str) -> None:
        """Abort the goal in progress, if there is one, and stop the robot."""
        if self._goal is not None:
            self._cmd_vel.stand()
            self._finish(self._goal, GoalStatus.ABORTED, self._failure(_UNKNOWN_ERROR, reason))

    def _accept(self, request: Any) -> bool:
        tick = self._tick
        if tick is None or tick.mode is not Mode.RUNNING:
            return False
        return self._pose(request.pose, tick) is not None

    def _begin(self, goal: ServerGoalHandle) -> None:
        self.abort("superseded by another goal")
        assert self._tick is not None
        pose = self._pose(goal.request.pose, self._tick)
        assert pose is not None
        self._goal, self._target, self._ending = goal, pose, None
        self._start_time = self._progress_time = self._tick.time
        self._least_remaining = math.inf
        self._standing_since: float | None = None
        self._corrections = 0
        logger.info("walking to (%.2f m, %.2f m, %.2f rad)", pose.x, pose.y, pose.heading)

    def _cancel(self, goal: ServerGoalHandle) -> bool:
        if goal is not self._goal:
            return False
        self._end(GoalStatus.CANCELED, self._server.result_type(error_msg="cancelled"))
        return True

    def _pose(self, stamped: Any, tick: StampedTick) -> PlanarPose | None:
        """Return the pose of a message in the world; None if it is invalid."""
        p, o = stamped.pose.position, stamped.pose.orientation
        numbers = np.array([p.x, p.y, p.z, o.x, o.y, o.z, o.w])
        if not np.isfinite(numbers).all() or abs(np.linalg.norm(numbers[3:]) - 1.0) > 0.05:
            return None
        pose = PlanarPose(p.x, p.y, math.atan2(2.0 * (o.w * o.z + o.x * o.y),
                                         1.0 - 2.0 * (o.y * o.y + o.z * o.z)))  # fmt: skip
        frame = stamped.header.frame_id.lstrip("/")
        if frame in _ODOM_FRAMES:
            return pose
        if frame in (*_BASE_FRAMES, self._robot.base):
            return pose.in_world_of(self._robot_pose(tick))
        return None

    def _robot_pose(self, tick: StampedTick) -> PlanarPose:
        return PlanarPose(
            float(tick["q"][0]),
            float(tick["q"][1]),
            heading(self._robot, State(tick["q"], tick["v"])),
        )

    def _advance(self, goal: ServerGoalHandle, tick: StampedTick) -> None:
        here = self._robot_pose(tick)
        error = self._target.relative_to(here)
        now = tick.time  # a simulation may be slower than the clock
        if self._feedback_due.is_due(tick.stamp):
            self._send_feedback(goal, here, error, tick)
        if self._ending is None and not goal.client_alive:
            text = "the client of the goal has disconnected"
            self._end(GoalStatus.ABORTED, self._failure(_UNKNOWN_ERROR, text))
        if self._ending is None:
            self._walk(error, now)
        stands = self._stands(tick, now)
        if self._ending is not None and stands:
            self._finish_standing(goal, error)

    def _walk(self, error: PlanarPose, now: float) -> None:
        if self._arrived(error, 0.5):
            self._end(GoalStatus.SUCCEEDED, self._server.result_type())
            return
        share = float(self._speed_share.value)
        x, y, turn = (share * v for v in self._cmd_vel.max_velocity)
        controller = PoseController(
            (x, y, turn), max(_NEAR, 3.0 * float(self._tolerance.value)), _GAIN
        )
        remaining = controller.remaining(error)
        if remaining < self._least_remaining - _MIN_PROGRESS:
            self._least_remaining, self._progress_time = remaining, now
        elif now - self._progress_time > _STUCK_TIMEOUT:
            self._end(
                GoalStatus.ABORTED,
                self._failure(_TIMEOUT, "the robot makes no progress towards the goal"),
            )
            return
        self._cmd_vel.walk(controller.velocity(error), _VELOCITY_TIMEOUT)

    def _arrived(self, error: PlanarPose, share: float) -> bool:
        return error.distance < share * float(self._tolerance.value) and abs(
            error.heading
        ) < share * float(self._heading_tolerance.value)

    def _end(self, state: GoalStatus, result: Any) -> None:
        """Stop the robot; the goal is over when it stands."""
        self._ending = (state, result)
        self._standing_since = None
        self._cmd_vel.stand()

    def _stands(self, tick: StampedTick, now: float) -> bool:
        """Return whether the robot has stood for a while."""
        if tick.phase != "stand":
            self._standing_since = None
            return False
        if self._standing_since is None:
            self._standing_since = now
        return now - self._standing_since > _STANDING_TIME

    def _finish_standing(self, goal: ServerGoalHandle, error: PlanarPose) -> None:
        assert self._ending is not None
        state, result = self._ending
        if state is GoalStatus.SUCCEEDED and not self._arrived(error, 1.0):
            self._corrections += 1  # the last steps carried it past
            self._ending = None
            if self._corrections > _MAX_CORRECTIONS:
                text = f"the robot stands {error.distance:.2f} m and {error.heading:.2f} rad off"
                self._end(GoalStatus.ABORTED, self._failure(_TIMEOUT, text))
            return
        self._finish(goal, state, result)

    def _finish(self, goal: ServerGoalHandle, state: GoalStatus, result: Any) -> None:
        self._goal = self._ending = None
        logger.info("walking to a pose: %s", result.error_msg or state.name.lower())
        goal.finish(state, result)

    def _failure(self, code: int, text: str) -> Any:
        return self._server.result_type(error_code=code, error_msg=text)

    def _send_feedback(
        self, goal: ServerGoalHandle, here: PlanarPose, error: PlanarPose, tick: StampedTick
    ) -> None:
        feedback: Any = self._server.feedback_type()
        pose = feedback.current_pose
        pose.header.stamp, pose.header.frame_id = stamp_from_seconds(tick.stamp), ODOM
        pose.pose.position.x, pose.pose.position.y = here.x, here.y
        pose.pose.orientation.z = math.sin(0.5 * here.heading)
        pose.pose.orientation.w = math.cos(0.5 * here.heading)
        feedback.navigation_time = duration_from_seconds(tick.time - self._start_time)
        pace = float(self._speed_share.value) * self._cmd_vel.max_velocity[0]
        feedback.estimated_time_remaining = duration_from_seconds(error.distance / pace)
        feedback.number_of_recoveries = self._corrections
        feedback.distance_remaining = error.distance
        goal.publish_feedback(feedback)
