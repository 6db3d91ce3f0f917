"""`/diagnostics`: timing of the control loop and state of the robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wbc.command import Status
from wbc.messages import message_type
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.stamp import stamp_from_seconds
from wbc.runtime.mode import Mode
from wbc.runtime.quantities import STATUSES
from wbc.runtime.rate_limiter import RateLimiter

_ARRAY = message_type("diagnostic_msgs/msg/DiagnosticArray")
_STATUS = message_type("diagnostic_msgs/msg/DiagnosticStatus")
_VALUE = message_type("diagnostic_msgs/msg/KeyValue")
_OK, _WARN, _ERROR = 0, 1, 2
_SOLVED = STATUSES.index(Status.OK)


@dataclass
class _Window:
    """What the ticks since the last message took.

    Attributes:
        times: time of estimator and controller in each tick, s.
        periods: wall time since the tick before, s.
        failures: number of ticks in which the QP had no solution.
    """

    times: list[float] = field(default_factory=list)
    periods: list[float] = field(default_factory=list)
    failures: int = 0

    def add(self, tick: StampedTick) -> None:
        """Add a tick."""
        self.times.append(float(tick["estimator_time"] + tick["controller_time"]))
        self.periods.append(float(tick["period"]))
        self.failures += int(tick["status"] != _SOLVED)


class Diagnostics:
    """Publishes statistics of the ticks, by default once per second.

    An overrun is a tick that came more than a period late.

    Args:
        node: node that publishes them.
        config: configuration of the node's process.
    """

    def __init__(self, node: Node, config: NodeConfig) -> None:
        self._publisher = node.create_publisher(_ARRAY.type_name, "/diagnostics")
        self._title = f"{node.fully_qualified_name.lstrip('/')}: control loop"
        self._robot, self._dt = config.robot.name, config.dt
        # The parameter is named as in ROS 2's `diagnostic_updater`.
        period = node.declare_parameter(
            "diagnostic_updater.period", 1.0, "period of diagnostics, s", bounds=(0.05, 60.0)
        )
        self._limiter = RateLimiter(1.0 / period.value)
        period.on_change = lambda value: self._limiter.restart(1.0 / value)
        self._window = _Window()  # since the last message
        self._overruns = 0  # since the start

    def on_tick(self, tick: StampedTick) -> None:
        """Process a tick of the loop, and publish the statistics if they are due."""
        if tick.mode is Mode.RUNNING:
            self._window.add(tick)
        if self._limiter.is_due(tick.stamp):
            window, self._window = self._window, _Window()
            message: Any = _ARRAY(status=[self._status(tick, window)])
            message.header.stamp = stamp_from_seconds(tick.stamp)
            self._publisher.publish(message)

    def _status(self, tick: StampedTick, window: _Window) -> Any:
        failures, periods = window.failures, window.periods
        overruns = sum(period > 2.0 * self._dt for period in periods)
        self._overruns += overruns
        level, text = _OK, "running"
        if tick.mode is Mode.FALLEN:
            level, text = _ERROR, "fallen"
        elif tick.phase == "falling":
            level, text = _ERROR, "falling"
        elif failures:
            level, text = _ERROR, f"the QP had no solution in {failures} ticks"
        elif overruns:
            level, text = _WARN, f"{overruns} ticks were late"
        times = 1e6 * np.array(window.times or [0.0])
        p50, p99, largest = np.percentile(times, (50, 99, 100))
        span = sum(periods)
        values = {
            "tick p50 (µs)": f"{p50:.0f}",
            "tick p99 (µs)": f"{p99:.0f}",
            "tick max (µs)": f"{largest:.0f}",
            "rate (Hz)": f"{len(periods) / span:.1f}" if span > 0.0 else "0",
            "overruns": str(self._overruns),
            "QP status": STATUSES[int(tick["status"])].value,
            "recent QP failures": str(failures),
            "phase": tick.phase,
            "steps": str(int(tick["steps"])),
            "DCM error (mm)": f"{1e3 * tick['dcm_error']:.1f}",
            "time (s)": f"{tick.time:.2f}",
            "resets": str(tick.run - 1),
        }
        return _STATUS(
            level=level,
            name=self._title,
            message=text,
            hardware_id=self._robot,
            values=[_VALUE(key=key, value=value) for key, value in values.items()],
        )
