"""Robots on four feet in the robots table: what they do is stand, sway, squat, trot and turn."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

import wbc
from wbc.runtime.report import Report
from wbc.runtime.tick import Tick
from wbc.walking import ReferenceOffset

SWAY = 0.05  # times the height of the centre of mass, to either side
SQUAT = 0.1  # times the leg's length
BEGIN, CYCLES = 0.5, 3  # s, periods of 1 s of a sway or squat

Command = Callable[[float, wbc.QuadrupedWalker, Any], None]


class ComError:
    """An observer of the true centre of mass of a standing robot, against its reference.

    Args:
        walker: its reference offset is what the centre of mass is to do.
    """

    quantities = ()

    def __init__(self, walker: wbc.QuadrupedWalker) -> None:
        self._walker = walker
        self._data = walker.robot.model.createData()
        self._square_sum, self._ticks = 0.0, 0

    def begin(self, controller: Any, plant: Any) -> None:
        """See `wbc.runtime.protocols.Observer`."""

    def observe(self, tick: Tick) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        if tick.truth is None:
            return
        robot, data = self._walker.robot, self._data
        com = pin.centerOfMass(robot.model, data, tick.truth.q)
        pin.updateFramePlacements(robot.model, data)
        feet = np.mean([data.oMf[sole.frame_id].translation for sole in robot.soles], axis=0)
        offset = self._walker.reference_offset
        wanted = np.array([0.0, 0.0, self._walker.gait.com_height])
        wanted += 0.0 if offset is None else offset.com
        error = com - feet - wanted
        self._square_sum += float(error @ error)
        self._ticks += 1

    def end(self, report: Report) -> None:
        """See `wbc.runtime.protocols.Observer`."""

    @property
    def rms_mm(self) -> float:
        """Root of the mean square, mm."""
        return 1e3 * math.sqrt(self._square_sum / max(self._ticks, 1))


def simulate(
    robot: wbc.Robot, duration: float, before_tick: Command = lambda *_: None
) -> tuple[Report, float]:
    """Run a walker in closed loop; return the report and the error of the centre of mass, mm."""
    from wbc.sim import Mujoco

    walker = wbc.QuadrupedWalker(robot)
    error = ComError(walker)
    with Mujoco(robot, dt=walker.dt, seed=0) as plant:
        report = wbc.run(
            walker,
            plant,
            duration,
            observers=[error],
            before_tick=lambda t: before_tick(t, walker, plant),
            on_falling=lambda _: None,
        )
    return report, error.rms_mm


def sway_or_squat(robot: wbc.Robot, axis: int) -> tuple[Report, float]:
    """Move the centre of mass to both sides (axis 1), or down and up (axis 2), twice."""
    sway = SWAY * robot.com_height
    squat = SQUAT * robot.leg_length

    def command(now: float, walker: wbc.QuadrupedWalker, _: Any) -> None:
        offset = walker.reference_offset = ReferenceOffset()
        if not BEGIN < now < BEGIN + CYCLES:
            return
        # A sine wave begins with a jump of the velocity, which a smooth beginning spares the DCM.
        share = min((now - BEGIN) / 0.5, (BEGIN + CYCLES - now) / 0.5, 1.0)
        omega = 2.0 * math.pi
        s, c = math.sin(omega * now), math.cos(omega * now)
        if axis == 2:
            phase = omega * (now - BEGIN)
            offset.com[2] = 0.5 * squat * (math.cos(phase) - 1.0)
            offset.com_velocity[2] = -0.5 * squat * omega * math.sin(phase)
            offset.com_acceleration[2] = -0.5 * squat * omega * omega * math.cos(phase)
            return
        amplitude = sway * share
        offset.com[1] = amplitude * s
        offset.com_velocity[1] = amplitude * omega * c
        offset.com_acceleration[1] = -amplitude * omega * omega * s

    return simulate(robot, BEGIN + CYCLES + 0.5, command)
