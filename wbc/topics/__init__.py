"""Topics: the ROS 2 messages that the ticks of a run are published and logged as.

The log and the ROS 2 node publish the same topics, from the same declarations: those of
`wbc.runtime.quantities` and the composite messages of `wbc.topics.catalogue`.
"""

from wbc.topics.batch import BatchMaker, TickBatch
from wbc.topics.catalogue import latched_topics, tick_topics
from wbc.topics.commanded_wrench import CommandedWrench
from wbc.topics.latched import LatchedTopic
from wbc.topics.message_topic import MessageTopic, TopicMessage
from wbc.topics.numeric import NumericTopic

__all__ = [
    "BatchMaker",
    "CommandedWrench",
    "LatchedTopic",
    "MessageTopic",
    "NumericTopic",
    "TickBatch",
    "TopicMessage",
    "latched_topics",
    "tick_topics",
]
