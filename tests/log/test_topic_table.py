"""The messages of a topic are the ones that were added, in their order and whatever their sizes."""

from __future__ import annotations

import numpy as np
import pytest

from wbc.log.topic_table import TopicTable
from wbc.messages import Message, message_type

COUNT = 1300  # more than two of the blocks that the table stores


@pytest.fixture(scope="module")
def messages() -> list[Message]:
    """Joint states of two joints, and of one joint at every seventh index."""
    kind = message_type("sensor_msgs/msg/JointState")
    random = np.random.default_rng(0)
    return [
        kind(name=names, position=random.normal(size=len(names)))
        for names in (["knee"] if k % 7 == 3 else ["hip", "knee"] for k in range(COUNT))
    ]


@pytest.fixture(scope="module")
def table(messages: list[Message]) -> TopicTable:
    table = TopicTable("/joint_states", "sensor_msgs/msg/JointState")
    for k, message in enumerate(messages):
        table.add(10 * k, message.encode())
    return table


def test_messages_of_several_sizes_keep_their_order(
    table: TopicTable, messages: list[Message]
) -> None:
    assert len(table) == COUNT
    assert table.first == messages[0]
    assert table.messages() == messages
    np.testing.assert_array_equal(table.stamps, 10 * np.arange(COUNT))


def test_numbers_are_nan_where_a_message_has_another_count_of_them(
    table: TopicTable, messages: list[Message]
) -> None:
    expected = [m.position if len(m.position) == 2 else [np.nan, np.nan] for m in messages]
    np.testing.assert_array_equal(table.numbers("position"), expected)
