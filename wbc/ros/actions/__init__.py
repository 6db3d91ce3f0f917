"""Actions: goals that take time, with feedback, a result and cancellation.

An action consists of three services (`send_goal`, `cancel_goal`, `get_result`) and two topics
(`feedback`, `status`) below `<name>/_action`. Source: ROS 2 design, "Actions".
"""

from wbc.ros.actions.client import ActionClient, ClientGoalHandle
from wbc.ros.actions.goal_status import GoalStatus
from wbc.ros.actions.server import ActionServer, ServerGoalHandle

__all__ = ["ActionClient", "ActionServer", "ClientGoalHandle", "GoalStatus", "ServerGoalHandle"]
