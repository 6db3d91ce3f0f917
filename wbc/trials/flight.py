"""Detects flight phases in the true state of a run: for reports, never for control."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from wbc.robot import Robot, Sole
from wbc.runtime.report import Flight
from wbc.runtime.tick import Tick

_UNLOADED = 0.02  # load, as a share of the weight, below which the foot sensors measure only noise
_MIN_CLEARANCE = 2e-3  # m; soles below this height count as on the ground
_LANDING = 0.3  # s after touchdown in which the peak landing load is measured


@dataclass(frozen=True, slots=True)
class _Sample:
    """The true motion at one tick.

    Attributes:
        time: s.
        soles: (2, 3) sole centres in world axes, m.
        com: (3,) centre of mass in world axes, m.
        climb_rate: vertical velocity of the CoM, m/s.
        angular_momentum: (3,) about the CoM in world axes, N·m·s.
    """

    time: float
    soles: np.ndarray
    com: np.ndarray
    climb_rate: float
    angular_momentum: np.ndarray


class FlightDetector:
    """Detects when both soles leave the ground, and measures each flight.

    Take-off and touchdown come from the foot sensors, everything else from the true state.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._data = robot.model.createData()
        self._ground: float | None = None
        self._previous: _Sample | None = None
        self._take_off: _Sample | None = None
        self._rise = self._clearance = self._momentum_change = 0.0
        self._peak_load = 0.0
        self._touchdown_time = -np.inf
        self._flights: list[Flight] = []

    @property
    def flights(self) -> tuple[Flight, ...]:
        """The flights that have ended, in order of time."""
        return tuple(self._flights)

    def record(self, tick: Tick) -> None:
        """Update with the true state after a tick."""
        if tick.truth is None or not tick.measurement.foot_wrenches:
            return
        robot, data, q, v = self._robot, self._data, tick.truth.q, tick.truth.v
        momentum = pin.computeCentroidalMomentum(robot.model, data, q, v).angular.copy()
        placements = [pin.updateFramePlacement(robot.model, data, s.frame_id) for s in robot.soles]
        corners = [_lowest_corner(*pair) for pair in zip(robot.soles, placements, strict=True)]
        if self._ground is None:
            self._ground = min(corners)
        load = sum(float(w[2]) for w in tick.measurement.foot_wrenches.values()) / robot.weight
        self._record_load(tick.time, load)
        now = _Sample(
            tick.time,
            np.array([p.translation for p in placements]),
            data.com[0].copy(),
            float(data.vcom[0][2]),
            momentum,
        )
        # A measurement belongs to the true state of the previous tick.
        clearance = min(corners) - self._ground
        if load < _UNLOADED or (self._take_off is not None and clearance > _MIN_CLEARANCE):
            self._record_flight(self._previous or now, now, clearance)
        elif self._take_off is not None:
            self._record_landing(self._take_off, self._previous or now)
        self._previous = now

    def _record_load(self, time: float, load: float) -> None:
        self._peak_load = max(self._peak_load, load)
        if time - self._touchdown_time <= _LANDING:
            last = self._flights[-1]
            self._flights[-1] = replace(last, landing_load=max(last.landing_load, load))

    def _record_flight(self, before: _Sample, now: _Sample, clearance: float) -> None:
        if self._take_off is None:
            self._take_off = before
            self._rise = self._clearance = self._momentum_change = 0.0
        start = self._take_off
        self._rise = max(self._rise, float(now.com[2] - start.com[2]))
        self._clearance = max(self._clearance, clearance)
        if clearance > 0.0:
            change = np.linalg.norm(now.angular_momentum - start.angular_momentum)
            self._momentum_change = max(self._momentum_change, float(change))

    def _record_landing(self, start: _Sample, now: _Sample) -> None:
        self._take_off = None
        if self._clearance < _MIN_CLEARANCE:
            return
        moved = (now.soles - start.soles)[:, :2]
        self._flights.append(
            Flight(
                duration_s=now.time - start.time,
                take_off_speed_m_s=start.climb_rate,
                rise_mm=1e3 * self._rise,
                clearance_mm=1e3 * self._clearance,
                spin=float(np.linalg.norm(start.angular_momentum)),
                spin_change=self._momentum_change,
                landing_error_mm=1e3 * float(np.linalg.norm(moved, axis=1).max()),
                push_off_load=self._peak_load,
                landing_load=0.0,
            )
        )
        self._peak_load, self._touchdown_time = 0.0, now.time


def _lowest_corner(sole: Sole, placement: pin.SE3) -> float:
    """Height of the lowest corner of a sole, m."""
    tilt = np.abs(placement.rotation[2, :2]) @ np.array([sole.half_length, sole.half_width])
    return float(placement.translation[2] - tilt)
