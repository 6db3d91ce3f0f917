"""The knobs of a player, and what turning one does in the loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wbc.live.panel import Knob
from wbc.motions import MotionPlayer
from wbc.tasks import Task
from wbc.walking import Walker

VELOCITY = ("forward", "left", "turn")
SPEED = "speed"
_GAIN_SPAN = 10.0  # up and down, of weights and gains

#: Gait parameters that may be turned: (name, label, unit, lowest and highest share of the
#: robot's own). The step width goes down to what is safe for the feet.
_GAIT = (
    ("single_support", "swing time", "s", 0.7, 1.5),
    ("double_support", "double support", "s", 0.6, 2.0),
    ("swing_height", "swing height", "m", 0.5, 2.0),
    ("step_width", "step width", "m", 0.0, 1.25),
    ("com_height", "CoM height", "m", 0.94, 1.0),
    ("dcm_gain", "DCM gain", "1/s", 0.4, 2.0),
)


@dataclass(frozen=True)
class Setting:
    """A knob and what it does.

    Attributes:
        knob: as the page shows it.
        turn: takes the new value, between two ticks.
    """

    knob: Knob
    turn: Callable[[float], None]


def velocity_knobs(walker: Walker, turn: Callable[[int, float], None]) -> list[Setting]:
    """One per direction, as far as the robot's own gait goes."""
    labels = (("forward", "m/s"), ("left", "m/s"), ("turn left", "rad/s"))
    return [
        Setting(Knob(f"velocity.{name}", "velocity", *label, -most, most, 0.0), partial(turn, i))
        for i, (name, label, most) in enumerate(
            zip(VELOCITY, labels, walker.gait.max_velocity, strict=True)
        )
    ]


def speed_knob(turn: Callable[[float], None]) -> Setting:
    """Slow motion."""
    knob = Knob(SPEED, "time", "slow motion", "×", 0.05, 1.0, 1.0, logarithmic=True)
    return Setting(knob, turn)


def gait_knobs(walker: Walker) -> list[Setting]:
    """Timing, geometry and feedback of the gait."""
    gait = walker.gait

    def turn(name: str, value: float) -> None:
        walker.change_gait(replace(walker.gait, **{name: value}))

    found = []
    for name, label, unit, lowest, highest in _GAIT:
        now = float(getattr(gait, name))
        low = max(lowest * now, gait.least_width if name == "step_width" else 0.0)
        knob = Knob(f"gait.{name}", "gait", label, unit, low, highest * now, now)
        found.append(Setting(knob, partial(turn, name)))
    return found


def gain_knobs(player: MotionPlayer) -> list[Setting]:
    """Weight and gains of each of the walker's tasks.

    Where a task's rows differ, the knob stands at the largest of them, and the others keep
    their ratios.
    """
    found = []
    for task in player.walker.tasks:
        for what, unit in (("weight", ""), ("kp", "1/s²"), ("kd", "1/s")):
            base = np.array(getattr(task, what))
            most = float(base.max())
            if most <= 0.0:
                continue
            low, high = most / _GAIN_SPAN, most * _GAIN_SPAN
            name = f"{task.name}.{what}"
            knob = Knob(name, task.name, what, unit, low, high, most, logarithmic=True)
            found.append(Setting(knob, partial(_turn_gain, task, what, base / most)))
    return found


def _turn_gain(task: Task, what: str, shares: np.ndarray, value: float) -> None:
    setattr(task, what, value * shares)
