"""Topics of numbers: which ticks have a message, its stamp and its values."""

import numpy as np
import pytest

import wbc
from wbc.messages import message_type
from wbc.runtime.stream import TickStream
from wbc.topics import BatchMaker, NumericTopic, TickBatch
from wbc.topics.batch import BatchKinematics

Point = message_type("geometry_msgs/msg/PointStamped")


def batch_of(points, period=0.002):
    """Return a batch whose CoM is given for each tick."""
    stamps = 1_500_000_000 + np.arange(len(points)) * round(1e9 * period)
    points = np.array(points, float)
    kinematics = BatchKinematics({}, points, points, np.zeros((len(points), 4)))
    return TickBatch(np.zeros(len(points)), stamps, lambda: kinematics)


def point_topic(period=0.0):
    message = Point()
    message.header.frame_id = "odom"
    return NumericTopic("com", message, lambda batch: {"point": batch.kinematics.com}, period)


def test_a_message_has_the_values_the_stamp_and_the_frame():
    ((ticks, data),) = point_topic().messages(batch_of([(1, 2, 3), (4, np.nan, 6)]))
    assert ticks.tolist() == [0, 1]
    message = Point.decode(data[1])
    assert (message.point.x, message.point.z) == (4.0, 6.0)
    assert np.isnan(message.point.y)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 502_000_000)
    assert message.header.frame_id == "odom"


def test_ticks_at_which_all_values_are_unknown_have_no_message():
    unknown = (np.nan,) * 3
    ((found, _),) = point_topic().messages(batch_of([unknown, (1, 2, 3), unknown]))
    assert found.tolist() == [1]
    assert point_topic().messages(batch_of([unknown])) == []


def test_a_topic_with_a_period_keeps_it_over_batches():
    topic, every = point_topic(period=0.01), batch_of([(k, 0, 0) for k in range(50)])
    ticks = []
    for start in range(0, 50, 7):
        chosen = np.arange(start, min(start + 7, 50))
        for found, _ in topic.messages(every.select(chosen)):
            ticks += [start + tick for tick in found.tolist()]
    assert ticks == list(range(0, 50, 5))


@pytest.mark.parametrize("times", [(0.0, 0.5, 0.0, 0.5), (0.0, 0.5, np.nan, np.nan)])
def test_stamps_go_on_over_a_reset_and_while_the_time_is_unknown(times):
    robot = wbc.load("simple_humanoid")
    records = np.zeros(4, TickStream(robot).schema.dtype)
    records["q"], records["time"] = robot.q_nominal, times
    stamps = BatchMaker(robot).batch(records).stamps
    assert stamps.tolist() == [0, 500_000_000, 1_000_000_000, 1_500_000_000]
