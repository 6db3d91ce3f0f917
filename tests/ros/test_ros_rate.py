"""Rates of topics, up to 500 Hz without loss on the loopback interface."""

from __future__ import annotations

import numpy as np
import pytest
from rostools import MessageCollector, PeerProcess, node, unused_domain

from wbc.ros import QoSProfile
from wbc.ros.bridge.catch_up import CatchUpPace
from wbc.ros.qos import HIGH_RATE
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.stream import CAPACITY

pytest.importorskip("cyclonedds")

RATE = 500


@pytest.mark.parametrize(
    "seconds", [2, pytest.param(60, marks=pytest.mark.slow)], ids="{} s".format
)
def test_no_message_is_lost_at_500_hz(seconds):
    domain = unused_domain()
    number = RATE * seconds
    sender = PeerProcess.start_peer(
        domain, "publish_numbers", str(RATE), str(number), str(HIGH_RATE.depth)
    )
    with sender, node("local", domain) as local_node:
        received = MessageCollector(
            local_node, "sensor_msgs/msg/JointState", "joint_states", QoSProfile(depth=10_000)
        )
        # A busy machine may send late, but every message that is sent must arrive.
        local_node.spin_until(lambda: len(received) >= number, 5.0 * seconds + 20.0)
        numbers = [int(m.position[0]) for m in received.messages]
        assert numbers == list(range(number))


def played(pace, max_rate, loop_rate, seconds, backlog):
    """Yield time and number of ticks of each reading, and how many then wait."""
    time, arrived, taken = 0.0, backlog, 0
    while time < seconds:
        waiting = int(arrived) - taken
        count = min(pace.at_once(waiting, max_rate), waiting)
        taken += count
        yield time, count, waiting - count
        wait = (pace.pause if waiting > count else pace.period)(max_rate)
        time, arrived = time + wait, arrived + wait * loop_rate


@pytest.mark.parametrize("held_up", [0.05, 0.2, 0.5])
def test_a_subscription_that_keeps_ten_gets_all_that_a_node_held_up_has_missed(held_up):
    """It takes what has come every 9 ms."""
    kept, next_take = 0, 0.0
    readings = list(played(CatchUpPace(0.002), RATE, RATE, 1.0, RATE * held_up))
    for time, count, _ in readings:
        if time >= next_take:
            kept, next_take = 0, time + 0.009
        kept += count
        assert kept <= 10
    assert readings[-1][2] <= 1


@pytest.mark.parametrize("max_rate", [1.0, 50.0, 500.0])
def test_a_node_keeps_up_with_a_loop_that_is_ten_times_faster_than_real_time(max_rate):
    loop_rate = 10 * RATE
    backlogs = [left for *_, left in played(CatchUpPace(0.002), max_rate, loop_rate, 5.0, 0)]
    assert max(backlogs) < CAPACITY // 4


def test_a_node_without_subscriptions_waits_instead_of_computing():
    evaluated = []
    with node("idle", unused_domain()) as idle:
        idle.spin_until(lambda: evaluated.append(None), 0.4)
    assert 1 <= len(evaluated) <= 10


def test_rate_is_kept_despite_jitter():
    limiter = RateLimiter(500.0, tolerance=0.001)
    stamps = [0.002 * i + 0.0004 * (-1) ** i for i in range(1000)]
    assert sum(map(limiter.is_due, stamps)) == 1000
    limiter = RateLimiter(50.0, tolerance=0.001)
    assert sum(map(limiter.is_due, stamps)) == 100


def test_missed_stamps_are_not_made_up_for():
    limiter = RateLimiter(100.0)
    assert limiter.is_due(0.0)
    assert limiter.is_due(10.0)
    assert not limiter.is_due(10.005)
    assert limiter.is_due(10.01)


def test_rate_limiter_restarts_when_the_clock_jumps_back():
    limiter = RateLimiter(100.0)
    assert limiter.is_due(1e9)
    assert not limiter.is_due(1e9 - 0.005)  # the clock was adjusted
    assert limiter.is_due(0.0)
    assert not limiter.is_due(0.005)
    assert limiter.is_due(0.01)


def test_limiters_restarted_together_with_equal_rates_select_the_same_stamps():
    first, second = RateLimiter(40.0), RateLimiter(50.0)
    stamps = np.cumsum(np.random.default_rng(0).exponential(0.008, 2000))
    for stamp in stamps[:1000]:
        first.is_due(stamp)
        second.is_due(stamp)
    for limiter in (first, second):
        limiter.restart(50.0)
    selected = [first.is_due(stamp) for stamp in stamps[1000:]]
    assert selected == [second.is_due(stamp) for stamp in stamps[1000:]]
    assert sum(selected) > 100
