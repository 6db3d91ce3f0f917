"""Topics: the ROS 2 messages that the ticks of a run are published and logged as.

The log and the ROS 2 node publish the same topics, from the same declarations: those of
`wbc.runtime.quantities` and the composite messages of `wbc.topics.catalogue`.
"""

from wbc.topics.batch import BatchMaker, TickBatch
from wbc.topics.catalogue import (
    CommandedWrenchTopics,
    column_fields,
    latched_topics,
    tick_topics,
)
from wbc.topics.numeric import NumericTopic
from wbc.topics.topic import LatchedTopic, MessageTopic, TopicMessage

__all__ = [
    "BatchMaker",
    "CommandedWrenchTopics",
    "LatchedTopic",
    "MessageTopic",
    "NumericTopic",
    "TickBatch",
    "TopicMessage",
    "column_fields",
    "latched_topics",
    "tick_topics",
]
