"""Status of a goal."""

from __future__ import annotations

from enum import IntEnum


class GoalStatus(IntEnum):
    """Status of a goal, as in `action_msgs/msg/GoalStatus`."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def terminal(self) -> bool:
        """Whether the status will not change any more."""
        return self >= GoalStatus.SUCCEEDED
