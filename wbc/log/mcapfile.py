"""The MCAP file: schemas, channels, chunks. Only the log's process uses this.

Source: MCAP format specification 0; profile and channel metadata as rosbag2 writes them
(`rosbag2_storage_mcap`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mcap.writer

import wbc
from wbc.log.describe import Facts
from wbc.log.output import Output
from wbc.log.topics import Block, Topic
from wbc.messages import schema_text, type_hash

_CHUNK = 64 * 1024 * 1024  # bytes: chunks end by time, not by size
_QOS = (
    "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    "  deadline:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  lifespan:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration:\n    sec: 2147483647\n    nsec: 4294967295\n"
    "  avoid_ros_namespace_conventions: false\n"
)


class McapFile:
    """A log being written.

    Args:
        path: of the file.

    Raises:
        OSError: it cannot be opened or written.
    """

    def __init__(self, path: Path) -> None:
        self._output = Output(path)
        self._writer = mcap.writer.Writer(self._output, chunk_size=_CHUNK)  # type: ignore[arg-type]
        self._writer.start("ros2", f"wbc {wbc.__version__}")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: dict[int, int] = {}
        self._output.commit()

    def add(self, facts: Facts) -> None:
        """Write down facts."""
        for name, table in facts.tables.items():
            self._writer.add_metadata(name, dict(table))
        for name, text in facts.files.items():
            kind = "application/json" if name.endswith(".json") else "text/plain"
            self._writer.add_attachment(0, 0, name, kind, text.encode())

    def write(self, block: Block, topics: Sequence[Topic]) -> None:
        """Write the messages of a block, in the order of time."""
        ticks: list[list[tuple[int, bytes]]] = [[] for _ in range(len(block))]
        for topic in topics:
            found = topic.messages(block)
            if found:
                channel = self._channel(topic)
                for index, data in found:
                    ticks[index].append((channel, data))
        add, sequence = self._writer.add_message, self._sequence
        for stamp, messages in zip(block.stamps.tolist(), ticks, strict=True):
            for channel, data in messages:
                sequence[channel] = number = sequence[channel] + 1
                add(channel, stamp, data, stamp, number)

    def commit(self) -> None:
        """End the chunk and bring it to the disk.

        Raises:
            OSError: it did not go; the file ends with the chunk before.
        """
        self._writer.flush()
        self._output.commit()

    def finish(self) -> None:
        """Write summary and footer.

        Raises:
            OSError: they did not go; the file ends with the last chunk.
        """
        self._writer.finish()
        self._output.commit()

    def close(self) -> None:
        """Close the file."""
        self._output.close()

    def _channel(self, topic: Topic) -> int:
        channel = self._channels.get(topic.name)
        if channel is None:
            durability, depth = (1, 1) if topic.latched else (2, 10)
            facts = {
                "offered_qos_profiles": _QOS.format(durability=durability, depth=depth),
                "topic_type_hash": type_hash(topic.type_name),
            }
            channel = self._writer.register_channel(
                topic.name, "cdr", self._schema(topic.type_name), facts
            )
            self._channels[topic.name] = channel
            self._sequence[channel] = 0
        return channel

    def _schema(self, type_name: str) -> int:
        schema = self._schemas.get(type_name)
        if schema is None:
            text = schema_text(type_name).encode()
            schema = self._writer.register_schema(type_name, "ros2msg", text)
            self._schemas[type_name] = schema
        return schema
