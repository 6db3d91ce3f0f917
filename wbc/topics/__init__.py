"""Topics: the ROS 2 messages that the ticks of a run are published and logged as.

The log and the ROS 2 node publish the same topics, from the same declarations: those of
`wbc.runtime.quantities` and the composite messages of `wbc.topics.catalogue`.
"""

from wbc.topics.batch import BatchMaker, TickBatch
from wbc.topics.catalogue import column_fields, tick_topics
from wbc.topics.numeric import NumericTopic
from wbc.topics.stream_topics import StreamTopics
from wbc.topics.topic import LatchedTopic, MessageBlock, MessageTopic

__all__ = [
    "BatchMaker",
    "LatchedTopic",
    "MessageBlock",
    "MessageTopic",
    "NumericTopic",
    "StreamTopics",
    "TickBatch",
    "column_fields",
    "tick_topics",
]
