"""`/diagnostics`: timing of the control loop and state of the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from wbc.command import Status
from wbc.messages import message_type
from wbc.ros.bridge.config import NodeConfig
from wbc.ros.bridge.stamped_tick import StampedTick
from wbc.ros.node import Node
from wbc.ros.rate_limiter import RateLimiter
from wbc.ros.stamp import stamp_from_seconds
from wbc.runtime.mode import Mode
from wbc.runtime.quantities import STATUSES

_ARRAY = message_type("diagnostic_msgs/msg/DiagnosticArray")
_STATUS = message_type("diagnostic_msgs/msg/DiagnosticStatus")
_VALUE = message_type("diagnostic_msgs/msg/KeyValue")
_OK, _WARN, _ERROR = 0, 1, 2


class Diagnostics:
    """Publishes statistics of the ticks, by default once per second.

    An overrun is a tick that came more than a period late.
    """

    def __init__(self, node: Node, config: NodeConfig) -> None:
        self._publisher = node.create_publisher(_ARRAY.type_name, "/diagnostics")
        self._name, self._robot, self._dt = (
            node.fully_qualified_name.lstrip("/"),
            config.robot.name,
            config.dt,
        )
        # Its name is that of ROS 2's own `diagnostic_updater`.
        period = node.declare_parameter(
            "diagnostic_updater.period", 1.0, "period of diagnostics, s", minimum=0.05, maximum=60.0
        )
        self._due = RateLimiter(1.0 / period.value)
        period.on_change = self._change_period
        self._ticks: list[float] = []
        self._periods: list[float] = []
        self._failures = self._overruns = self._all_overruns = 0

    def _change_period(self, period: float) -> None:
        self._due.restart(1.0 / period)

    def take(self, tick: StampedTick) -> None:
        """Take a tick of the loop."""
        if tick.mode is Mode.RUNNING:
            period = float(tick["period"])
            self._ticks.append(float(tick["estimator_time"] + tick["controller_time"]))
            self._periods.append(period)
            self._failures += STATUSES[int(tick["status"])] is not Status.OK
            self._overruns += period > 2.0 * self._dt
        if self._due.is_due(tick.stamp):
            self._tell(tick)

    def _tell(self, tick: StampedTick) -> None:
        self._all_overruns += self._overruns
        level, text = self._judgement(tick)
        ticks = 1e6 * np.array(self._ticks or [0.0])
        periods = np.array(self._periods or [0.0])
        status = _STATUS(
            level=level, name=f"{self._name}: control loop", message=text, hardware_id=self._robot
        )
        status.values = [
            _VALUE(key=key, value=value)
            for key, value in {
                "tick p50 (µs)": f"{np.percentile(ticks, 50):.0f}",
                "tick p99 (µs)": f"{np.percentile(ticks, 99):.0f}",
                "tick max (µs)": f"{ticks.max():.0f}",
                "rate (Hz)": f"{1.0 / periods.mean():.1f}" if periods.mean() > 0.0 else "0",
                "overruns": str(self._all_overruns),
                "QP status": STATUSES[int(tick["status"])].value,
                "QP failures lately": str(self._failures),
                "phase": tick.phase,
                "steps": str(int(tick["steps"])),
                "DCM error (mm)": f"{1e3 * tick['dcm_error']:.1f}",
                "time (s)": f"{tick.time:.2f}",
                "resets": str(tick.run - 1),
            }.items()
        ]
        message: Any = _ARRAY(status=[status])
        message.header.stamp = stamp_from_seconds(tick.stamp)
        self._publisher.publish(message)
        self._ticks.clear()
        self._periods.clear()
        self._failures = self._overruns = 0

    def _judgement(self, tick: StampedTick) -> tuple[int, str]:
        if tick.mode is Mode.FALLEN:
            return _ERROR, "fallen"
        if self._failures:
            return _ERROR, f"the QP had no solution in {self._failures} ticks"
        if self._overruns:
            return _WARN, f"{self._overruns} ticks came late"
        return _OK, "running"
