"""Reads logs, interrupted ones included."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wbc.errors import did_you_mean
from wbc.log.errors import LogError, require_packages
from wbc.log.robot_info import RobotInfo
from wbc.log.topic_table import TopicTable

if TYPE_CHECKING:
    from wbc.log.data_section import Gap


class Log:
    """The content of a log, by topic.

    Example:
        >>> Log("walk.mcap")["/joint_states"].numbers("effort").shape
        (5000, 32)

    Args:
        path: Path of the file.

    Attributes:
        path: Path of the file.
        complete: Whether the log was finished; otherwise it ends with its last whole chunk.
        gaps: What is missing because the file is damaged.
        tables: Parameters and versions; maps each table name to its names and values.
        files: Attached texts by file name, for example "robot.json".
        topics: The messages of each topic that has some, by topic name.

    Raises:
        LogError: The file does not exist, or is not an MCAP file of ROS 2 messages.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """

    def __init__(self, path: str | Path) -> None:
        require_packages()
        self.path = Path(path)
        self.complete = False
        self.gaps: tuple[Gap, ...] = ()
        self.tables: dict[str, dict[str, str]] = {}
        self.files: dict[str, str] = {}
        self.topics: dict[str, TopicTable] = {}
        try:
            self._read()
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

    def _read(self) -> None:
        from mcap.records import Attachment, Channel, Message, Metadata, Schema

        from wbc.log.data_section import ChunkBlock, DataSection
        from wbc.log.record_reader import chunk_records

        schemas: dict[int, str] = {}
        channels: dict[int, TopicTable] = {}

        def describe(record: Schema | Channel) -> None:
            if isinstance(record, Schema):
                schemas[record.id] = record.name
            elif record.message_encoding == "cdr":
                table = TopicTable(record.topic, schemas.get(record.schema_id, ""))
                channels[record.id] = self.topics.setdefault(record.topic, table)

        with self.path.open("rb") as file:
            section = DataSection(file)
            for one in section.summary.descriptions:
                describe(one)
            for _, content in section:
                if isinstance(content, ChunkBlock):
                    for record in chunk_records(content.content):
                        if not isinstance(record, Message):
                            describe(record)
                        elif record.channel_id in channels:
                            channels[record.channel_id].add(record.log_time, record.data)
                elif isinstance(content, Metadata):
                    self.tables[content.name] = content.metadata
                elif isinstance(content, Attachment):
                    self.files[content.name] = content.data.decode("utf-8", "replace")
        self.complete, self.gaps = section.finished, tuple(section.gaps)
        self.topics = {name: table for name, table in sorted(self.topics.items()) if len(table)}
