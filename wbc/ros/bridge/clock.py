"""`/clock`: the plant time of a simulated robot, and its use for message stamps."""

from __future__ import annotations

from dataclasses import replace

from wbc.messages import message_type
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.qos import CLOCK
from wbc.ros.stamp import stamp_from_seconds
from wbc.runtime.rate_limiter import RateLimiter

_CLOCK = message_type("rosgraph_msgs/msg/Clock")
_RATE = 100.0  # Hz of the wall clock


class PlantClock:
    """Publishes the plant's time on `/clock`, and stamps messages with it if `use_sim_time` is set.

    Nodes whose `use_sim_time` is true take their time from `/clock` and expect stamps of that time.
    The parameter `use_sim_time` of this node selects it; otherwise stamps are system time. The
    time is continuous over resets, because a time that jumps back clears the buffers of `tf2`.

    Args:
        node: node of a simulated robot.
        use_sim_time: initial value of the parameter.
    """

    def __init__(self, node: Node, use_sim_time: bool) -> None:
        self._use_sim_time = node.declare_parameter(
            "use_sim_time", use_sim_time, "stamp messages with the plant's time"
        )
        self._publisher = node.create_publisher(_CLOCK.type_name, "/clock", CLOCK)
        # Ticks may arrive at just this rate, and with jitter.
        self._limiter = RateLimiter(_RATE, 0.4 / _RATE)
        self._run = 0
        self._offset = self._latest = 0.0

    def stamp(self, tick: StampedTick) -> StampedTick:
        """Publish the time of a tick; return the tick with the stamp of its messages."""
        if tick.run != self._run:
            self._run, self._offset = tick.run, self._latest
        self._latest = tick.time + self._offset
        if self._limiter.is_due(tick.stamp):
            self._publisher.publish(_CLOCK(clock=stamp_from_seconds(self._latest)))
        return replace(tick, stamp=self._latest) if self._use_sim_time.value else tick
