"""Reads logs, interrupted ones included."""

from __future__ import annotations

import importlib.util
import json
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from wbc.errors import MissingExtra, did_you_mean
from wbc.log.errors import LogError
from wbc.log.format.reading import (
    DamagedChunk,
    chunk_data,
    file_records,
    inner_records,
    message_at,
    string_at,
)
from wbc.log.format.records import (
    ATTACHMENT,
    CHANNEL,
    CHUNK,
    FOOTER,
    MAGIC,
    MESSAGE,
    METADATA,
    SCHEMA,
)
from wbc.log.robot_info import RobotInfo
from wbc.log.topic_table import Table
from wbc.messages import Message

_U32 = struct.Struct("<I")


class Log:
    """The content of a log, by topic.

    Args:
        path: Path of the file.

    Attributes:
        path: Path of the file.
        complete: Whether the log was finished; otherwise it ends with its last whole chunk.
        tables: Parameters and versions; maps each table name to its names and values.
        files: Attached texts by file name, for example "robot.json".

    Raises:
        LogError: The file does not exist, or is not an MCAP file of ROS 2 messages.
        MissingExtra: `zstandard` is not installed.
    """

    def __init__(self, path: str | Path) -> None:
        if importlib.util.find_spec("zstandard") is None:
            raise MissingExtra("zstandard", "log")
        self.path = Path(path)
        self.complete = False
        self.tables: dict[str, dict[str, str]] = {}
        self.files: dict[str, str] = {}
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, Table] = {}
        try:
            with self.path.open("rb") as file:
                for _, opcode, content in file_records(file):
                    if opcode == CHUNK:
                        self._read_chunk(content)
                    elif opcode == METADATA:
                        self._read_table(content)
                    elif opcode == ATTACHMENT:
                        self._read_file(content)
                    elif opcode == FOOTER:
                        self.complete = file.read(len(MAGIC)) == MAGIC
                        break
        except DamagedChunk:
            pass  # everything before it has been read
        except OSError as error:
            raise LogError(f"cannot read {self.path}: {error.strerror}") from error
        self._topics = {table.topic: table for table in self._channels.values() if len(table)}

    @property
    def topics(self) -> dict[str, str]:
        """The type of each topic that has messages, sorted by topic name."""
        return {name: self._topics[name].type_name for name in sorted(self._topics)}

    def __contains__(self, topic: str) -> bool:
        """Return whether the log has messages of a topic."""
        return topic in self._topics

    def stamps(self, topic: str) -> np.ndarray:
        """Return the log times of a topic's messages, ns, shape (n,).

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).stamps()

    def numbers(self, topic: str, field: str) -> np.ndarray:
        """Return the values of a field in all messages of a topic, shape (n, k).

        Args:
            topic: Topic name, for example "/joint_states".
            field: Field path, for example "position", "pose.pose.position" or
                "transforms[0].transform".

        Raises:
            LogError: The log has no messages of the topic, or they have no numeric field of that
                name.
        """
        return self._table(topic).numbers(field)

    def messages(self, topic: str) -> list[Message]:
        """Return the messages of a topic whose messages are kept whole (see `Table`).

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).messages()

    def first(self, topic: str) -> Message:
        """Return the first message of a topic.

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).first

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
        """Return the terrain as upright boxes: centre and half sizes, m, shape (n, 6)."""
        try:
            boxes = json.loads(self.files.get("terrain.json", "{}")).get("boxes", [])
            return np.array(boxes, float).reshape(-1, 6)
        except (ValueError, AttributeError) as error:
            raise LogError(f"{self.path}: the terrain cannot be parsed: {error}") from error

    def _table(self, topic: str) -> Table:
        table = self._topics.get(topic)
        if table is None:
            raise LogError(
                f"{self.path} has no messages of topic '{topic}'{did_you_mean(topic, self._topics)}"
            )
        return table

    def _read_chunk(self, content: bytes) -> None:
        data = chunk_data(content)
        found: dict[int, tuple[list[int], list[bytes]]] = {}
        for opcode, start, stop in inner_records(data):
            if opcode == MESSAGE:
                channel, stamp, message = message_at(data, start, stop)
                stamps, messages = found.setdefault(channel, ([], []))
                stamps.append(stamp)
                messages.append(message)
            elif opcode == SCHEMA:
                self._read_schema(data[start:stop])
            elif opcode == CHANNEL:
                self._read_channel(data[start:stop])
        for channel, (stamps, messages) in found.items():
            if channel in self._channels:
                self._channels[channel].add(stamps, messages)

    def _read_schema(self, content: bytes) -> None:
        (number,) = struct.unpack_from("<H", content)
        name, _ = string_at(content, 2)
        self._schemas[number] = name

    def _read_channel(self, content: bytes) -> None:
        number, schema = struct.unpack_from("<HH", content)
        topic, at = string_at(content, 4)
        encoding, _ = string_at(content, at)
        if encoding == "cdr" and number not in self._channels:
            self._channels[number] = Table(topic, self._schemas.get(schema, ""))

    def _read_table(self, content: bytes) -> None:
        name, at = string_at(content, 0)
        (size,) = _U32.unpack_from(content, at)
        texts = list(_strings(content, at + 4, at + 4 + size))
        self.tables[name] = dict(zip(texts[::2], texts[1::2], strict=False))

    def _read_file(self, content: bytes) -> None:
        name, at = string_at(content, 16)
        _, at = string_at(content, at)
        (size,) = struct.unpack_from("<Q", content, at)
        self.files[name] = content[at + 8 : at + 8 + size].decode("utf-8", "replace")


def _strings(content: bytes, at: int, stop: int) -> Iterator[str]:
    while at < stop:
        text, at = string_at(content, at)
        yield text
