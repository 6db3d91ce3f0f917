"""The messages of a log written by the library and by the package `mcap`, compared."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from wbc.log.mcapfile import McapFile
from wbc.topics import MessageTopic, TickBatch, TopicMessage

CHUNK = 0.4  # s, as in the log writer
BLOCK = 50  # ticks per batch, as in the log writer, ten batches per second


class RecordedTopic(MessageTopic):
    """A topic whose messages have been read from a file."""

    def __init__(self, name: str, type_name: str) -> None:
        self.name, self.type_name = name, type_name
        self.now: list[TopicMessage] = []

    def messages(self, batch: TickBatch) -> list[TopicMessage]:
        """See `MessageTopic.messages`."""
        return self.now


@dataclass
class Messages:
    """All messages of a log in order of time.

    Attributes:
        topics: Topic of each channel.
        schemas: Name and definition of each channel's type.
        rows: Channel, stamp (ns) and data of each message.
    """

    topics: dict[int, RecordedTopic] = field(default_factory=dict)
    schemas: dict[int, tuple[str, bytes]] = field(default_factory=dict)
    rows: list[tuple[int, int, bytes]] = field(default_factory=list)

    @staticmethod
    def of(path: Path) -> Messages:
        """Read the messages of a log."""
        found = Messages()
        with path.open("rb") as file:
            for schema, channel, message in make_reader(file).iter_messages():
                assert schema is not None
                found.topics.setdefault(channel.id, RecordedTopic(channel.topic, schema.name))
                found.schemas[channel.id] = (schema.name, schema.data)
                found.rows.append((channel.id, message.log_time, message.data))
        return found

    @property
    def seconds(self) -> float:
        """Time from the first to the last message, s."""
        return 1e-9 * (self.rows[-1][1] - self.rows[0][1])

    def share(self) -> dict[str, float]:
        """Return the compressed size of each topic, MB per minute."""
        import zstandard

        found = {}
        for number, topic in self.topics.items():
            data = [data for channel, _, data in self.rows if channel == number]
            step = max(1, round(len(data) * CHUNK / self.seconds))
            pieces = [b"".join(data[i : i + step]) for i in range(0, len(data), step)]
            size = sum(len(zstandard.compress(piece, 3)) for piece in pieces)
            found[topic.name] = size / 1e6 / (self.seconds / 60.0)
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def written_here(self, path: Path) -> float:
        """Write the messages with `McapFile`; return the CPU time, s."""
        blocks = self._blocks()
        start = time.process_time()
        file = McapFile(path)
        due = 0
        for stamps, found in blocks:
            for number, topic in self.topics.items():
                topic.now = found[number]
            nothing = np.empty(0)
            batch = TickBatch(stamps, [], stamps, {}, nothing, nothing)
            file.write(batch, list(self.topics.values()))
            if stamps[-1] >= due:
                file.commit()
                due = stamps[-1] + 1e9 * CHUNK
        file.commit()
        file.finish()
        file.close()
        return time.process_time() - start

    def _blocks(self) -> Sequence[tuple[np.ndarray, dict[int, list[TopicMessage]]]]:
        ticks: dict[int, list[tuple[int, bytes]]] = {}
        for channel, stamp, data in self.rows:
            ticks.setdefault(stamp, []).append((channel, data))
        stamps = sorted(ticks)
        blocks = []
        for i in range(0, len(stamps), BLOCK):
            some = stamps[i : i + BLOCK]
            found: dict[int, list[TopicMessage]] = {number: [] for number in self.topics}
            for k, stamp in enumerate(some):
                for channel, data in ticks[stamp]:
                    found[channel].append(TopicMessage(k, data))
            blocks.append((np.array(some), found))
        return blocks

    def written_by_package(self, path: Path) -> float:
        """Write the messages with the writer of `mcap`; return the CPU time, s."""
        size = sum(len(data) for _, _, data in self.rows)
        start = time.process_time()
        with path.open("wb") as file:
            chunk = round(size * CHUNK / self.seconds)
            writer = Writer(file, chunk_size=chunk, compression=CompressionType.ZSTD)
            writer.start("ros2", "benchmark")
            numbers = {}
            for number, topic in self.topics.items():
                name, text = self.schemas[number]
                schema = writer.register_schema(name, "ros2msg", text)
                numbers[number] = writer.register_channel(topic.name, "cdr", schema)
            for channel, stamp, data in self.rows:
                writer.add_message(numbers[channel], stamp, data, stamp)
            writer.finish()
        return time.process_time() - start


def compare_writers(path: Path) -> dict[str, float]:
    """Write a log's messages both ways; return CPU time (µs per message, min. of 3) and size."""
    messages = Messages.of(path)
    found: dict[str, float] = {}
    for name, write in (
        ("here", messages.written_here),
        ("package", messages.written_by_package),
    ):
        copy = path.with_name(f"{name}.mcap")
        spent = min(write(copy) for _ in range(3))
        found[f"{name}_us_per_message"] = 1e6 * spent / len(messages.rows)
        found[f"{name}_cpu_percent"] = 100.0 * spent / messages.seconds
        found[f"{name}_megabytes"] = copy.stat().st_size / 1e6
    return found
