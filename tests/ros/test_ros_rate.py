"""At 500 Hz nothing is lost on the loopback interface."""

from __future__ import annotations

import numpy as np
import pytest
from rostools import Hearer, Peer, new_domain, node

from wbc.ros import QoSProfile
from wbc.ros.qos import HIGH_RATE
from wbc.runtime.rate_limiter import RateLimiter

pytest.importorskip("cyclonedds")

RATE = 500


@pytest.mark.parametrize(
    "seconds", [2, pytest.param(60, marks=pytest.mark.slow)], ids="{} s".format
)
def test_no_message_is_lost_at_500_hz(seconds):
    domain = new_domain()
    number = RATE * seconds
    sender = Peer.of(domain, "count", str(RATE), str(number), str(HIGH_RATE.depth))
    with sender, node("here", domain) as here:
        heard = Hearer(here, "sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=10_000))
        # A busy machine may be slower than the clock; but what is sent must come.
        here.spin_until(lambda: len(heard) >= number, 5.0 * seconds + 20.0)
        numbers = [int(m.position[0]) for m in heard.messages]
        assert numbers == list(range(number))


def test_a_rate_is_kept_over_jitter():
    due = RateLimiter(500.0, tolerance=0.001)
    stamps = [0.002 * i + 0.0004 * (-1) ** i for i in range(1000)]
    assert sum(map(due.is_due, stamps)) == 1000
    due = RateLimiter(50.0, tolerance=0.001)
    assert sum(map(due.is_due, stamps)) == 100


def test_what_was_missed_is_not_made_up_for():
    due = RateLimiter(100.0)
    assert due.is_due(0.0)
    assert due.is_due(10.0)
    assert not due.is_due(10.005)
    assert due.is_due(10.01)


def test_a_clock_that_jumps_back_is_another_clock():
    due = RateLimiter(100.0)
    assert due.is_due(1e9)
    assert not due.is_due(1e9 - 0.005)  # a clock that was set
    assert due.is_due(0.0)
    assert not due.is_due(0.005)
    assert due.is_due(0.01)


def test_those_restarted_at_once_with_one_rate_are_due_together():
    one, other = RateLimiter(40.0), RateLimiter(50.0)
    stamps = np.cumsum(np.random.default_rng(0).exponential(0.008, 2000))
    for stamp in stamps[:1000]:
        one.is_due(stamp)
        other.is_due(stamp)
    for due in (one, other):
        due.restart(50.0)
    told = [one.is_due(stamp) for stamp in stamps[1000:]]
    assert told == [other.is_due(stamp) for stamp in stamps[1000:]]
    assert sum(told) > 100
