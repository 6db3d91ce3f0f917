"""The signals that the page draws over time: every number of a tick, and its limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from wbc.runtime.schema import Column, Schema

if TYPE_CHECKING:
    from wbc.robot import Robot

Bounds = tuple[float | None, float | None]

_POSITIONS = ("joint_position", "q", "q_target", "true_q")
_VELOCITIES = ("joint_velocity", "v", "v_target", "true_v")
_TORQUES = ("tau",)
_TIMES = ("estimator_time", "controller_time", "period")
_UNLIMITED = 1e3  # larger limits are those of a description without any


def signal_places(schema: Schema) -> dict[str, int]:
    """Return the place of every number of a tick in its record, by its label."""
    labels = [column.label(i) for column in schema.numbers for i in range(column.size)]
    return {label: place for place, label in enumerate(labels)}


def signal_limits(schema: Schema, robot: Robot, dt: float) -> dict[str, Bounds]:
    """Return the limits of those signals that have any, by their labels.

    Args:
        schema: Schema of the ticks.
        robot: Robot of the ticks, whose joint limits are shown.
        dt: Control period, s, which is the budget of a tick.
    """
    limits: dict[str, Bounds] = {}
    for column in schema.numbers:
        if column.name in _TIMES:
            limits[column.label(0)] = (None, dt)
        elif column.name in _POSITIONS:
            limits |= _joint_limits(column, robot.q_min, robot.q_max)
        elif column.name in _VELOCITIES:
            limits |= _joint_limits(column, -robot.v_max, robot.v_max)
        elif column.name in _TORQUES:
            limits |= _joint_limits(column, -robot.tau_max, robot.tau_max)
    return limits


def _joint_limits(column: Column, low: np.ndarray, high: np.ndarray) -> dict[str, Bounds]:
    """Return the limits of a column whose last numbers are those of the joints."""
    first = column.size - len(low)
    found = {
        column.label(first + i): (_known(bounds[0]), _known(bounds[1]))
        for i, bounds in enumerate(zip(low.tolist(), high.tolist(), strict=True))
    }
    return {label: bounds for label, bounds in found.items() if bounds != (None, None)}


def _known(limit: float) -> float | None:
    return limit if math.isfinite(limit) and abs(limit) < _UNLIMITED else None
