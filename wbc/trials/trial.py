"""What is simulated: undisturbed runs, and trials that are forked from them."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from wbc.trials.condition import Condition
from wbc.trials.controllers import ControllerSpec
from wbc.trials.digest import path_digest, text_digest
from wbc.trials.disturbance import Disturbance

Velocity = tuple[float, float, float]


@dataclass(frozen=True)
class UndisturbedRun:
    """A run without any disturbance, from which trials are forked.

    Attributes:
        robot: name of a robot, or path of a URDF or robot data file.
        controller: the controller.
        velocity: commanded: forward, left (m/s), turn (rad/s); all zero to stand.
        condition: in what the plant differs from the nominal one.
        seed: seed of sensor noise and terrain.
    """

    robot: str
    controller: ControllerSpec
    velocity: Velocity
    condition: Condition
    seed: int

    @property
    def stands(self) -> bool:
        """Whether the robot is to stand."""
        return not any(self.velocity)

    @cached_property
    def key(self) -> str:
        """Identifies the run by all that decides its result; the same on every machine."""
        return _key(self._content())

    def _content(self) -> dict[str, Any]:
        content = asdict(self)
        content["controller"] = self.controller.content()
        if Path(self.robot).is_file():
            content["robot"] = path_digest(self.robot)
        # Without defaults, a new kind of condition leaves the keys of all other trials alone.
        nominal = asdict(Condition(self.condition.name))
        condition = content["condition"]
        content["condition"] = {k: v for k, v in condition.items() if v != nominal[k]}
        return content


@dataclass(frozen=True)
class Trial:
    """A disturbance at one phase of an undisturbed run.

    Attributes:
        run: the undisturbed run.
        phase: when: share of a gait cycle after the end of the warm-up.
        disturbance: kind of the disturbance.
        direction: degrees counter-clockwise from the robot's heading.
        size: in the unit of the disturbance.
        duration: time that is simulated from the disturbance on, s.
    """

    run: UndisturbedRun
    phase: Fraction
    disturbance: Disturbance
    direction: float
    size: float
    duration: float

    @cached_property
    def key(self) -> str:
        """Identifies the trial by all that decides its result; the same on every machine."""
        return _key(
            {
                "run": self.run.key,
                "phase": str(self.phase),
                "disturbance": asdict(self.disturbance),
                "direction": self.direction,
                "size": self.size,
                "duration": self.duration,
            }
        )


def _key(content: dict[str, Any]) -> str:
    return text_digest(json.dumps(content, sort_keys=True))
