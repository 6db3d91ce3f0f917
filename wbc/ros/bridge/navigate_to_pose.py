"""The action `navigate_to_pose`, which walks to a pose, of the type that Nav2 defines.

With Nav2's own type, RViz's goal tool, `ros2 action` and every client of Nav2 can send goals, and
nothing needs to be built on the ROS side. The type is that of Jazzy; later releases of Nav2 have
appended fields to the feedback. The field `behavior_tree` is ignored here.

A goal may be given in `odom`, in the robot's base, or in a frame that `/tf` connects with `odom`,
such as `map`. Unless it is connected, `map` is taken for `odom`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wbc.geometry.planar import Placement
from wbc.messages import Message
from wbc.robot import Robot
from wbc.robot.attitude import heading
from wbc.ros.actions import GoalStatus, ServerGoalHandle
from wbc.ros.bridge.cmd_vel import CmdVel
from wbc.ros.bridge.robot_action import RobotAction
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.bridge.transform_listener import TransformListener, placement_of
from wbc.ros.node import Node
from wbc.ros.stamp import duration_from_seconds, stamp_from_seconds
from wbc.runtime.schema import ODOM
from wbc.state import State
from wbc.teleop import CommandRefused
from wbc.walking import WaypointFollower

NAME = "navigate_to_pose"
TYPE = "nav2_msgs/action/NavigateToPose"
_BASE_FRAMES = ("base_link", "base_footprint")  # besides the robot's own name of its base
_VELOCITY_TIMEOUT = 0.5  # s after which the robot stops unless another velocity is sent
_STANDING_TIME = 0.3  # s for which the gait has to stand
_NEAR = 0.8  # m, within which the robot steps in any direction
_GAIN = 0.6  # 1/s
_PROGRESS_TIMEOUT = 20.0  # s without progress
_MIN_PROGRESS = 0.03  # m
_MAX_CORRECTIONS = 5  # of a robot that stands beside the goal
_UNKNOWN_ERROR, _TIMEOUT = 9000, 9003  # error codes of Nav2


class NavigateToPose(RobotAction):
    """Serves the action.

    Args:
        node: node that serves the action.
        cmd_vel: sends the velocities; a message on `cmd_vel` aborts the goal.
        robot: the robot.
    """

    def __init__(self, node: Node, cmd_vel: CmdVel, robot: Robot) -> None:
        super().__init__(node, TYPE, NAME)
        self._cmd_vel, self._robot = cmd_vel, robot
        self._transforms = TransformListener(node)
        self._speed_ratio = node.declare_parameter(
            "walk_speed", 0.6, "speed, as a fraction of the largest velocity", bounds=(0.1, 1.0)
        )
        self._tolerance = node.declare_parameter(
            "position_tolerance", 0.1, "position tolerance of the goal, m", bounds=(0.02, 1.0)
        )
        self._heading_tolerance = node.declare_parameter(
            "heading_tolerance", 0.15, "heading tolerance of the goal, rad", bounds=(0.05, math.pi)
        )
        for parameter in (self._speed_ratio, self._tolerance, self._heading_tolerance):
            parameter.on_change = self._renew_follower
        self._renew_follower()
        self._target = Placement(0j, 0.0)
        cmd_vel.on_override = lambda: self.abort("cmd_vel took over")

    def _renew_follower(self, _: float = 0.0) -> None:
        tolerance = (self._tolerance.value, self._heading_tolerance.value)
        self._follower = WaypointFollower(
            self._cmd_vel.max_velocity.scaled(self._speed_ratio.value),
            (_GAIN, _GAIN, _GAIN),
            near=max(_NEAR, 3.0 * self._tolerance.value),
            reached=(0.5 * tolerance[0], 0.5 * tolerance[1]),
            left=tolerance,
        )

    def abort(self, reason: str) -> None:
        """Abort the goal in progress, if there is one, and stop the robot."""
        if self._goal is not None:
            self._cmd_vel.stand()
        super().abort(reason)

    def _check(self, goal: Any) -> None:
        super()._check(goal)
        self._parse_pose(goal.pose)

    def _start(self, goal: Any, tick: StampedTick) -> None:
        target = self._target = self._parse_pose(goal.pose)
        self._renew_follower()
        self._start_time = self._progress_time = tick.time
        self._min_remaining = math.inf
        self._standing_since: float | None = None
        self._corrections = 0
        self._error_code = _UNKNOWN_ERROR
        turn = target.relative_to(self._robot_pose(tick)).yaw
        if not self._cmd_vel.max_velocity.turn and abs(turn) > self._heading_tolerance.value:
            self._stop(
                GoalStatus.ABORTED,
                "the robot cannot turn (at most 0 rad/s), and the goal's heading is "
                f"{turn:.2f} rad from its own; send a goal with the robot's heading",
            )

    def _parse_pose(self, stamped: Any) -> Placement:
        """Return the pose of a message in the frame odom.

        Raises:
            CommandRefused: a number is invalid, or nothing connects its frame with odom.
        """
        p, o = stamped.pose.position, stamped.pose.orientation
        numbers = np.array([p.x, p.y, p.z, o.x, o.y, o.z, o.w])
        if not np.isfinite(numbers).all():
            raise CommandRefused("a number of the pose is not finite")
        norm = float(np.linalg.norm(numbers[3:]))
        if abs(norm - 1.0) > 0.05:
            raise CommandRefused(f"the norm of the quaternion is {norm:.3g}, not 1")
        pose = placement_of(p, o)
        frame = stamped.header.frame_id.lstrip("/")
        # A map of which no transform has come yet is refused: it may be anywhere.
        transformed = self._transforms.transform(pose, frame or ODOM, ODOM)
        if transformed is not None:
            return transformed
        if frame in (*_BASE_FRAMES, self._robot.base) and self._tick is not None:
            return self._robot_pose(self._tick).compose(pose)
        raise CommandRefused(f"no transform on /tf connects the frame {frame!r} with {ODOM!r}")

    def _robot_pose(self, tick: StampedTick) -> Placement:
        q = tick["q"]
        return Placement(complex(q[0], q[1]), heading(self._robot, State(q, tick["v"])))

    def _update(self, goal: ServerGoalHandle, tick: StampedTick) -> None:
        super()._update(goal, tick)
        pose = self._robot_pose(tick)
        if self._outcome is None:
            self._walk(pose, tick.time)
        if self._outcome is not None and self._is_standing(tick):
            self._finish_standing(self._target.relative_to(pose), *self._outcome)

    def _walk(self, pose: Placement, time: float) -> None:
        follower = self._follower
        velocity = follower.velocity(self._target, pose)
        if follower.position_reached and follower.yaw_reached:
            self._stop(GoalStatus.SUCCEEDED, "")
            return
        remaining = follower.remaining(self._target, pose)
        if remaining < self._min_remaining - _MIN_PROGRESS:
            self._min_remaining, self._progress_time = remaining, time
        elif time - self._progress_time > _PROGRESS_TIMEOUT:
            self._error_code = _TIMEOUT
            self._stop(GoalStatus.ABORTED, "the robot makes no progress towards the goal")
            return
        self._cmd_vel.walk(velocity, _VELOCITY_TIMEOUT)

    def _stop_robot(self) -> None:
        self._standing_since = None
        self._cmd_vel.stand()

    def _is_standing(self, tick: StampedTick) -> bool:
        if tick.phase != "stand":
            self._standing_since = None
            return False
        if self._standing_since is None:
            self._standing_since = tick.time
        return tick.time - self._standing_since > _STANDING_TIME

    def _finish_standing(self, error: Placement, status: GoalStatus, text: str) -> None:
        distance, angle = self._tolerance.value, self._heading_tolerance.value
        reached = abs(error.point) < distance and abs(error.yaw) < angle
        if status is not GoalStatus.SUCCEEDED or reached:
            self._finish(status, text)
        elif self._corrections < _MAX_CORRECTIONS:  # the last steps led away from the goal
            self._corrections += 1
            self._outcome = None
            self._renew_follower()
        else:
            self._error_code = _TIMEOUT
            text = f"the robot stands {abs(error.point):.2f} m and {error.yaw:.2f} rad off"
            self._finish(GoalStatus.ABORTED, text)

    def _result(self, status: GoalStatus, text: str) -> Message:
        code = self._error_code if status is GoalStatus.ABORTED else 0
        return self._server.result_type(error_code=code, error_msg=text)

    def _time_left(self, pose: Placement) -> float:
        """Return the time until the goal ends, s: the way, two steps to stop, and standing."""
        walking = 0.0 if self._outcome else self._follower.time_left(self._target, pose)
        return walking + 2.0 * self._cmd_vel.step_duration + _STANDING_TIME

    def _feedback(self, tick: StampedTick) -> Message:
        here = self._robot_pose(tick)
        distance = abs(self._target.point - here.point)
        feedback = self._server.feedback_type(
            navigation_time=duration_from_seconds(tick.time - self._start_time),
            estimated_time_remaining=duration_from_seconds(self._time_left(here)),
            number_of_recoveries=self._corrections,
            distance_remaining=distance,
        )
        pose = feedback.current_pose
        pose.header.stamp, pose.header.frame_id = stamp_from_seconds(tick.stamp), ODOM
        pose.pose.position.x, pose.pose.position.y = here.point.real, here.point.imag
        pose.pose.orientation.z = math.sin(0.5 * here.yaw)
        pose.pose.orientation.w = math.cos(0.5 * here.yaw)
        return feedback
