"""Finds flights in the truth of a run: for reports, never for control."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from wbc.robot import Robot, Sole
from wbc.runtime.report import Flight
from wbc.runtime.tick import Tick

_FREE = 0.02  # share of the weight: what is less is the sensors' noise
_LEAST = 2e-3  # m: soles that do not get higher have not flown
_AFTER = 0.3  # s after touchdown in which the landing's largest load is looked for


@dataclass(frozen=True, slots=True)
class _Instant:
    """What is true at a tick."""

    time: float
    soles: np.ndarray  # (2, 3) centres, m
    com: np.ndarray
    rising: float  # m/s
    spin: np.ndarray  # angular momentum about the CoM


class FlightDetector:
    """Watches whether both soles leave the ground, and what becomes of it.

    That the ground lets go, and when, the foot sensors tell; everything else is the truth.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._data = robot.model.createData()
        self._ground: float | None = None
        self._before: _Instant | None = None
        self._take_off: _Instant | None = None
        self._rise = self._clearance = self._change = 0.0
        self._load = 0.0
        self._landed = -np.inf
        self._flights: list[Flight] = []

    @property
    def flights(self) -> tuple[Flight, ...]:
        """Those that are over."""
        return tuple(self._flights)

    def record(self, tick: Tick) -> None:
        """Look at the truth after a tick."""
        if tick.truth is None or not tick.measurement.foot_wrenches:
            return
        robot, data, q, v = self._robot, self._data, tick.truth.q, tick.truth.v
        spin = pin.computeCentroidalMomentum(robot.model, data, q, v).angular.copy()
        placements = [pin.updateFramePlacement(robot.model, data, s.frame_id) for s in robot.soles]
        corners = [_lowest(*pair) for pair in zip(robot.soles, placements, strict=True)]
        if self._ground is None:
            self._ground = min(corners)
        load = sum(float(w[2]) for w in tick.measurement.foot_wrenches.values()) / robot.weight
        self._carry(tick.time, load)
        now = _Instant(
            tick.time,
            np.array([p.translation for p in placements]),
            data.com[0].copy(),
            float(data.vcom[0][2]),
            spin,
        )
        # A measurement is as old as the truth of the tick before.
        clear = min(corners) - self._ground
        if load < _FREE or (self._take_off is not None and clear > _LEAST):
            self._fly(self._before or now, now, clear)
        elif self._take_off is not None:
            self._land(self._take_off, self._before or now)
        self._before = now

    def _carry(self, time: float, load: float) -> None:
        self._load = max(self._load, load)
        if time - self._landed <= _AFTER:
            last = self._flights[-1]
            self._flights[-1] = replace(last, landing_load=max(last.landing_load, load))

    def _fly(self, before: _Instant, now: _Instant, clear: float) -> None:
        if self._take_off is None:
            self._take_off = before
            self._rise = self._clearance = self._change = 0.0
        start = self._take_off
        self._rise = max(self._rise, float(now.com[2] - start.com[2]))
        self._clearance = max(self._clearance, clear)
        if clear > 0.0:
            self._change = max(self._change, float(np.linalg.norm(now.spin - start.spin)))

    def _land(self, start: _Instant, now: _Instant) -> None:
        self._take_off = None
        if self._clearance < _LEAST:
            return
        moved = (now.soles - start.soles)[:, :2]
        self._flights.append(
            Flight(
                duration_s=now.time - start.time,
                take_off_speed_m_s=start.rising,
                rise_mm=1e3 * self._rise,
                clearance_mm=1e3 * self._clearance,
                spin=float(np.linalg.norm(start.spin)),
                spin_change=self._change,
                landing_error_mm=1e3 * float(np.linalg.norm(moved, axis=1).max()),
                push_off_load=self._load,
                landing_load=0.0,
            )
        )
        self._load, self._landed = 0.0, now.time


def _lowest(sole: Sole, placement: pin.SE3) -> float:
    """Height of a sole's lowest corner, m."""
    tilt = np.abs(placement.rotation[2, :2]) @ np.array([sole.half_length, sole.half_width])
    return float(placement.translation[2] - tilt)
