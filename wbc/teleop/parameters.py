"""The parameters that can be set while the robot runs. A row here is a slider on the live page."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wbc.teleop.number_checks import check_number
from wbc.walking import Walker

VELOCITY, TIME, GAIT = "velocity", "time", "gait"  # groups; the others are names of tasks
TIME_SCALE = "speed"

#: Gait parameters: (name, label, unit, lowest and highest share of the robot's own value). The
#: step width goes down to what is safe for the feet.
_GAIT = (
    ("single_support", "Swing time", "s", 0.7, 1.5),
    ("double_support", "Double support", "s", 0.6, 2.0),
    ("swing_height", "Swing height", "m", 0.5, 2.0),
    ("step_width", "Step width", "m", 0.0, 1.25),
    ("com_height", "CoM height", "m", 0.94, 1.0),
    ("dcm_gain", "DCM gain", "1/s", 0.4, 2.0),
)
_VELOCITY = (("forward", "Forward", "m/s"), ("left", "Left", "m/s"), ("turn", "Turn left", "rad/s"))
_GAINS = {"weight": ("Weight", ""), "kp": ("kp", "1/s²"), "kd": ("kd", "1/s")}
_GAIN_RANGE = 10.0  # gains go from a tenth to ten times their value
_OFF = 1e-9  # of a weight; zero would lose the ratios of a task's rows


@dataclass(frozen=True, slots=True)
class TunableParameter:
    """A number that a command may set.

    Attributes:
        name: unique, e.g. "gait.swing_height" or "com.weight".
        group: "velocity", "time", "gait", or the name of a task.
        label: name for people.
        unit: unit of the value.
        low: smallest value.
        high: largest value.
        default: value at the start.
        logarithmic: whether equal ratios, not differences, make equal steps of a slider.
        switchable: whether 0 is possible beside the values from `low` on: it switches a task off.
    """

    name: str
    group: str
    label: str
    unit: str
    low: float
    high: float
    default: float
    logarithmic: bool = False
    switchable: bool = False

    def check(self, value: Any) -> float:
        """Return a value if it is a number and within the bounds.

        Raises:
            CommandRefused: it is not.
        """
        low = 0.0 if self.switchable and value == 0 else self.low
        return check_number(self.name, value, low, self.high, self.unit)


def tunable_parameters(walker: Walker, time_scale: bool) -> tuple[TunableParameter, ...]:
    """Return the parameters of a walker: velocity, time scale, gait, and gains of its tasks.

    The gain of a task with several rows is that of the largest row.

    Args:
        walker: the walker.
        time_scale: whether the loop can run slower than real time.
    """
    gait = walker.gait
    limits = gait.max_velocity
    least = [0.0 - most for most in (limits.backward, limits.left, limits.turn)]  # no minus zero
    found = [
        TunableParameter(f"{VELOCITY}.{name}", VELOCITY, label, unit, low, high, 0.0)
        for (name, label, unit), low, high in zip(_VELOCITY, least, limits.largest, strict=True)
    ]
    if time_scale:
        found.append(TunableParameter(TIME_SCALE, TIME, "Speed", "×", 0.05, 1.0, 1.0, True))
    for name, label, unit, lowest, highest in _GAIT:
        value = float(getattr(gait, name))
        low = max(lowest * value, gait.least_width if name == "step_width" else 0.0)
        found.append(
            TunableParameter(f"{GAIT}.{name}", GAIT, label, unit, low, highest * value, value)
        )
    for task in walker.tasks:
        for gain, (label, unit) in _GAINS.items():
            value = float(np.max(getattr(task, gain)))
            if value > 0.0:
                bounds = (value / _GAIN_RANGE, value * _GAIN_RANGE)
                name = f"{task.name}.{gain}"
                switchable = gain == "weight"
                parameter = TunableParameter(
                    name, task.name, label, unit, *bounds, value, True, switchable
                )
                found.append(parameter)
    return tuple(found)


def set_parameter(walker: Walker, name: str, value: float) -> None:
    """Set a gait parameter or a gain of a walker, at any tick.

    Args:
        walker: the walker.
        name: name of a `TunableParameter`, e.g. "gait.swing_height" or "com.weight".
        value: its value; of a gain with several rows that of the largest row, to which the other
            rows keep their ratios. A weight of 0 leaves the task a billionth of 1.
    """
    group, _, field = name.rpartition(".")
    if group == GAIT:
        changes: dict[str, Any] = {field: value}
        walker.change_gait(replace(walker.gait, **changes))
        return
    task = next(task for task in walker.tasks if task.name == group)
    rows = np.array(getattr(task, field))
    setattr(task, field, max(value, _OFF) * (rows / np.max(rows)))
