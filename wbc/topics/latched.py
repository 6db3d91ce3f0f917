"""Latched topics: one message, which late subscribers receive, too."""

from __future__ import annotations

from abc import abstractmethod

from wbc.messages import message_type
from wbc.robot import Robot
from wbc.topics.batch import TickBatch
from wbc.topics.message_topic import MessageTopic, TopicMessage


class LatchedTopic(MessageTopic):
    """A topic with a single message that does not depend on ticks."""

    latched = True
    _sent = False

    @abstractmethod
    def encode(self) -> bytes:
        """Return the message, CDR."""

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """Return the message with the first tick; see `MessageTopic.messages`."""
        if self._sent or not len(batch):
            return []
        self._sent = True
        return [TopicMessage(0, self.encode())]


class RobotDescription(LatchedTopic):
    """`robot_description`: the robot's URDF.

    Args:
        robot: Robot to describe.
    """

    name = "robot_description"
    type_name = "std_msgs/msg/String"

    def __init__(self, robot: Robot) -> None:
        self._text = robot.urdf_path.read_text("utf-8", "replace").replace("\0", "")

    def encode(self) -> bytes:
        """Return the message, CDR."""
        return message_type(self.type_name)(data=self._text).encode()
