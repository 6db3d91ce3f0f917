"""The action `follow_joint_trajectory`, of the type that MoveIt and `ros2_control` share.

Arms, trunk and head follow the trajectory at its own times and velocities, standing or walking.
Path tolerances and joints with several degrees of freedom are ignored.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.messages import Message, message_type
from wbc.robot import Robot
from wbc.ros.actions import GoalStatus
from wbc.ros.bridge.joint_topics import JointTopics, TrajectoryExecution
from wbc.ros.bridge.robot_action import RobotAction
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.stamp import duration_from_seconds, stamp_from_seconds, to_seconds

NAME = "follow_joint_trajectory"
TYPE = "control_msgs/action/FollowJointTrajectory"
_POINT = message_type("trajectory_msgs/msg/JointTrajectoryPoint")
_GOAL_TOLERANCE = 0.1  # rad, unless the goal states one
_TIME_TOLERANCE = 1.0  # s, unless the goal states one
_INVALID_GOAL, _GOAL_TOLERANCE_VIOLATED = -1, -5  # error codes of the type


class FollowJointTrajectory(RobotAction):
    """Serves the action.

    Args:
        node: node that serves the action.
        joints: follows the trajectory; another joint command aborts the goal.
        robot: the robot.
    """

    def __init__(self, node: Node, joints: JointTopics, robot: Robot) -> None:
        super().__init__(node, TYPE, NAME)
        self._joints, self._robot = joints, robot
        self._execution: TrajectoryExecution | None = None
        self._error_code = _INVALID_GOAL

    def abort(self, reason: str) -> None:
        """Abort the goal in progress, if there is one, and stay at the latest point."""
        if self._goal is not None and self._joints.execution is self._execution:
            self._joints.cancel_trajectory()
        super().abort(reason)

    def _check(self, goal: Any) -> None:
        super()._check(goal)
        self._joints.parse(goal.trajectory)

    def _start(self, goal: Any, tick: StampedTick) -> None:
        self._error_code = _INVALID_GOAL
        trajectory = self._joints.parse(goal.trajectory)
        self._execution = self._joints.execute(trajectory)
        self._index = [self._robot.joint_names.index(name) for name in trajectory.joints]
        stated = {one.name: one.position for one in goal.goal_tolerance if one.position > 0.0}
        self._tolerance = np.array([stated.get(n, _GOAL_TOLERANCE) for n in trajectory.joints])
        self._time_tolerance = to_seconds(goal.goal_time_tolerance) or _TIME_TOLERANCE

    def _update(self, goal: Any, tick: StampedTick) -> None:
        super()._update(goal, tick)
        execution = self._execution
        if self._goal is None or execution is None:
            return
        if self._joints.execution is not execution:
            self.abort("another joint command took over")
            return
        trajectory = execution.trajectory
        late = execution.elapsed - trajectory.times[-1]
        if late < 0.0:
            return
        error = np.abs(self._positions(tick) - trajectory.positions[-1])
        if (error <= self._tolerance).all():
            self._finish(GoalStatus.SUCCEEDED)
        elif late > self._time_tolerance:
            worst = int(np.argmax(error - self._tolerance))
            self._error_code = _GOAL_TOLERANCE_VIOLATED
            self._finish(
                GoalStatus.ABORTED,
                f"'{trajectory.joints[worst]}' is {error[worst]:.3f} rad off after "
                f"{late:.1f} s; tolerance {self._tolerance[worst]:.3f} rad",
            )

    def _stop_robot(self) -> None:
        assert self._outcome is not None
        if self._joints.execution is self._execution:
            self._joints.cancel_trajectory()
        self._finish(*self._outcome)

    def _positions(self, tick: StampedTick) -> np.ndarray:
        positions: np.ndarray = np.asarray(tick["q"])[7:][self._index]
        return positions

    def _result(self, status: GoalStatus, text: str) -> Message:
        code = self._error_code if status is GoalStatus.ABORTED else 0
        return self._server.result_type(error_code=code, error_string=text)

    def _feedback(self, tick: StampedTick) -> Message:
        assert self._execution is not None
        trajectory, elapsed = self._execution.trajectory, self._execution.elapsed
        desired, actual = trajectory.at(elapsed), self._positions(tick)
        time = duration_from_seconds(max(elapsed, 0.0))
        feedback = self._server.feedback_type(
            joint_names=list(trajectory.joints),
            desired=_POINT(positions=desired, time_from_start=time),
            actual=_POINT(positions=actual, time_from_start=time),
            error=_POINT(positions=desired - actual, time_from_start=time),
        )
        feedback.header.stamp = stamp_from_seconds(tick.stamp)
        return feedback
