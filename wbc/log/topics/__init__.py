"""What the log's process makes of ticks: ROS 2 messages, topic by topic."""

from wbc.log.topics.block import Block, Tracker
from wbc.log.topics.contacts import CommandedWrench
from wbc.log.topics.fixed import FixedTopic
from wbc.log.topics.sets import topics_of
from wbc.log.topics.topic import Topic, TopicMessage

__all__ = [
    "Block",
    "CommandedWrench",
    "FixedTopic",
    "Topic",
    "TopicMessage",
    "Tracker",
    "topics_of",
]
