"""Reads logs, interrupted ones included."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Container, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.errors import did_you_mean
from wbc.log.errors import LogError, require_packages
from wbc.log.robot_info import RobotInfo
from wbc.log.time_span import WHOLE_RUN, TimeSpan
from wbc.log.topic_table import TopicTable

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

    from wbc.log.data_section import ChunkPlace, Gap


class Log:
    """The content of a log, by topic.

    Example:
        >>> Log("walk.mcap")["/joint_states"].numbers("effort").shape
        (5000, 32)

    Args:
        path: Path of the file.
        span: Part of the run to read.
        topics: Names of the topics to read; all by default.
        progress: Called with the share of the file that has been read, 0 to 1.

    Attributes:
        path: Path of the file.
        span: Part of the run that was read.
        complete: Whether the log was finished; otherwise it ends with its last whole chunk.
        gaps: What is missing because the file is damaged.
        tables: Parameters and versions; maps each table name to its names and values.
        files: Attached texts by file name, for example "robot.json".
        topics: The messages of each topic that has some, by topic name.

    Raises:
        LogError: The file does not exist, or is not an MCAP file of ROS 2 messages.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        span: TimeSpan = WHOLE_RUN,
        topics: Container[str] | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> None:
        require_packages()
        self.path, self.span = Path(path), span
        self.complete = False
        self.gaps: tuple[Gap, ...] = ()
        self.tables: dict[str, dict[str, str]] = {}
        self.files: dict[str, str] = {}
        self.topics: dict[str, TopicTable] = {}
        self._chunks: list[ChunkPlace] = []
        self._descriptions: list[Schema | Channel] = []
        try:
            self._read(span, topics, progress)
        except OSError as error:
            raise LogError(f"cannot read {self.path}: {error.strerror}") from error

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the topics."""
        return iter(self.topics)

    def __contains__(self, topic: object) -> bool:
        """Return whether the log has messages of a topic."""
        return topic in self.topics

    def __getitem__(self, topic: str) -> TopicTable:
        """Return the messages of a topic, for example "/joint_states".

        Raises:
            LogError: The log has no messages of the topic.
        """
        if topic not in self:
            raise LogError(
                f"{self.path} has no messages of topic '{topic}'{did_you_mean(topic, self.topics)}"
            )
        return self.topics[topic]

    def robot_info(self) -> RobotInfo:
        """Return the properties of the robot.

        Raises:
            LogError: The log does not state them.
        """
        try:
            return RobotInfo.from_json(self.files["robot.json"])
        except (KeyError, ValueError, TypeError) as error:
            raise LogError(
                f"{self.path} does not describe its robot: wbc did not write it"
            ) from error

    def boxes(self) -> np.ndarray:
        """Return the terrain as boxes, shape (n, 6) or (n, 8); see `wbc.sim.Terrain`."""
        try:
            boxes = json.loads(self.files.get("terrain.json", "{}")).get("boxes", [])
            return np.array(boxes, float).reshape(len(boxes), -1) if boxes else np.empty((0, 6))
        except (ValueError, AttributeError) as error:
            raise LogError(f"{self.path}: the terrain cannot be parsed: {error}") from error

    def between(self, span: TimeSpan, topics: Container[str] | None = None) -> Log:
        """Return the log with the messages of a part of the run only.

        It takes as long as the part is: the file is not read from its beginning.

        Args:
            span: Part of the run.
            topics: Names of the topics to read; all by default.

        Raises:
            LogError: The file cannot be read.
        """
        from wbc.log.data_section import read_chunk

        part, messages = copy.copy(self), _Messages(span, topics)
        for description in self._descriptions:
            messages.describe(description)
        try:
            with self.path.open("rb") as file:
                for place in self._chunks:
                    if span.overlaps(place.start, place.end):
                        messages.add(read_chunk(file, place))
        except (OSError, ValueError) as error:
            raise LogError(f"cannot read {self.path} any more: {error}") from error
        part.span, part.topics = span, messages.by_topic()
        return part

    def _read(
        self,
        span: TimeSpan,
        topics: Container[str] | None,
        progress: Callable[[float], None],
    ) -> None:
        from mcap.records import Attachment, Metadata

        from wbc.log.data_section import ChunkBlock, ChunkPlace, DataSection

        messages = _Messages(span, topics)
        size = max(self.path.stat().st_size, 1)
        with self.path.open("rb") as file:
            section = DataSection(file, span)
            for one in section.summary.descriptions:
                messages.describe(one)
            for block, content in section:
                if isinstance(content, ChunkBlock):
                    messages.add(content.content)
                    self._chunks.append(ChunkPlace.of(block, content.record))
                    progress(block.end / size)
                elif isinstance(content, Metadata):
                    self.tables[content.name] = content.metadata
                elif isinstance(content, Attachment):
                    self.files[content.name] = content.data.decode("utf-8", "replace")
        self.complete, self.gaps = section.finished, tuple(section.gaps)
        self._descriptions = messages.descriptions
        self.topics = messages.by_topic()


class _Messages:
    """Sorts the messages of chunks by topic.

    Attributes:
        descriptions: Schemas and channels so far.
    """

    def __init__(self, span: TimeSpan, topics: Container[str] | None) -> None:
        self._whole, self._first, self._last = span.whole, 1e9 * span.start, 1e9 * span.end
        self._wanted = topics
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, TopicTable] = {}
        self._topics: dict[str, TopicTable] = {}
        self.descriptions: list[Schema | Channel] = []

    def describe(self, record: Schema | Channel) -> None:
        """Learn a schema, or a channel, whose messages are kept from now on."""
        from mcap.records import Schema

        self.descriptions.append(record)
        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif record.message_encoding == "cdr" and (
            self._wanted is None or record.topic in self._wanted
        ):
            table = TopicTable(record.topic, self._schemas.get(record.schema_id, ""))
            self._channels[record.id] = self._topics.setdefault(record.topic, table)

    def add(self, content: bytes) -> None:
        """Add the messages of a chunk with a content."""
        from wbc.log.record_reader import TimedMessage, chunk_records

        for record in chunk_records(content, self._channels):
            if not isinstance(record, TimedMessage):
                self.describe(record)
            elif self._whole or self._first <= record.log_time <= self._last:
                self._channels[record.channel].add(record.log_time, record.data)

    def by_topic(self) -> dict[str, TopicTable]:
        """Return the messages of each topic that has some, by topic name."""
        return {name: table for name, table in sorted(self._topics.items()) if len(table)}
