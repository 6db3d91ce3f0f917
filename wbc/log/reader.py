"""Reads logs: whole ones, and what is there of interrupted ones."""

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
    """Everything in a log, by topic.

    Args:
        path: of the file.

    Attributes:
        path: of the file.
        complete: it was finished properly; otherwise it ends with its last whole chunk.
        tables: parameters and versions: name -> names and values.
        files: attached texts, e.g. "robot.json".

    Raises:
        LogError: there is no such file, or it is no MCAP file of ROS 2 messages.
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
            pass  # what came before it is there
        except OSError as error:
            raise LogError(f"cannot read {self.path}: {error.strerror}") from error
        self._topics = {table.topic: table for table in self._channels.values() if len(table)}

    @property
    def topics(self) -> dict[str, str]:
        """Name -> type of the topics that have messages, sorted."""
        return {name: self._topics[name].type_name for name in sorted(self._topics)}

    def __contains__(self, topic: str) -> bool:
        """Whether there are messages of a topic."""
        return topic in self._topics

    def stamps(self, topic: str) -> np.ndarray:
        """(n,) when the messages of a topic were logged, ns.

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).stamps()

    def numbers(self, topic: str, field: str) -> np.ndarray:
        """(n, k) numbers of a field in all messages of a topic.

        Args:
            topic: e.g. "/joint_states".
            field: e.g. "position", "pose.pose.position", "transforms[0].transform".

        Raises:
            LogError: there are no messages of that topic, or they have no numbers of that name.
        """
        return self._table(topic).numbers(field)

    def messages(self, topic: str) -> list[Message]:
        """The messages of a topic of which the log keeps whole messages (see `Table`).

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).messages()

    def first(self, topic: str) -> Message:
        """The first message of a topic.

        Raises:
            LogError: there are no messages of that topic.
        """
        return self._table(topic).first

    def robot_info(self) -> RobotInfo:
        """What has to be known of the robot.

        Raises:
            LogError: the log does not say.
        """
        try:
            return RobotInfo.from_json(self.files["robot.json"])
        except (KeyError, ValueError, TypeError) as error:
            raise LogError(
                f"{self.path} does not describe its robot: it is no log of this library's"
            ) from error

    def boxes(self) -> np.ndarray:
        """(n, 6) terrain as it was told: centre and half sizes of upright boxes, m."""
        try:
            boxes = json.loads(self.files.get("terrain.json", "{}")).get("boxes", [])
            return np.array(boxes, float).reshape(-1, 6)
        except (ValueError, AttributeError) as error:
            raise LogError(f"{self.path}: its terrain cannot be understood: {error}") from error

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
