"""Queues of messages in shared memory."""

import os

import pytest

from wbc.process import BlobQueue, BlobQueueFull, BlobTooLarge


@pytest.fixture
def queues():
    """The writer's and the reader's side of a queue."""
    writer = BlobQueue(3, 100)
    return writer, BlobQueue(3, 100, os.dup(writer.descriptor))


def test_a_queue_delivers_messages_whole_and_in_order(queues):
    writer, reader = queues
    assert reader.get() is None
    for k in range(10):
        writer.put(bytes([k]) * k)
        writer.put(b"x" * 100)
        assert reader.get() == bytes([k]) * k
        assert reader.get() == b"x" * 100
    assert reader.get() is None


def test_a_full_queue_refuses_until_a_message_has_been_read(queues):
    writer, reader = queues
    for _ in range(3):
        writer.put(b"a")
    with pytest.raises(BlobQueueFull, match="3 messages wait"):
        writer.put(b"b")
    assert reader.get() == b"a"
    writer.put(b"b")
    assert [reader.get() for _ in range(4)] == [b"a", b"a", b"b", None]


def test_a_message_larger_than_a_slot_is_refused(queues):
    writer, reader = queues
    with pytest.raises(BlobTooLarge, match="101 bytes; at most 100"):
        writer.put(b"x" * 101)
    assert reader.get() is None
