"""Keyframes: a motion from a file of postures and positions over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from wbc.errors import MotionError
from wbc.motions.engine import Motion, MotionContext, Script, once_per_robot, parameter
from wbc.motions.keyframing import read_keyframes
from wbc.motions.keyframing.limits import check_limits
from wbc.motions.keyframing.plan import KeyframePlan, KeyframePlanner
from wbc.robot import Robot

_BLEND = 0.3  # s


@dataclass(frozen=True)
class Keyframes(Motion):
    """Play postures and positions from a CSV or YAML file, smoothed, checked, tracked in balance.

    Between keyframes run cubic splines, twice continuously differentiable, from standing at 0 s
    to rest at the last keyframe. Positions, velocities, torques and the ZMP are checked along
    the whole motion before it starts.
    """

    name: ClassVar[str] = "keyframes"
    summary: ClassVar[str] = "play postures and positions of the hands from a CSV or YAML file"

    file: str = parameter("", "path of the file", suffixes=(".csv", ".yaml", ".yml"))
    hold: float = parameter(0.5, "pause at the last keyframe, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        if not self.file:
            raise MotionError("keyframes: which file? give it by  --file FILE.csv  or  file=…")
        if not 0.0 <= self.hold < float("inf"):
            raise MotionError(f"keyframes: hold = {self.hold} s must be finite and not negative")
        self._plan(robot)

    @once_per_robot
    def _plan(self, robot: Robot) -> KeyframePlan:
        path = Path(self.file).expanduser()
        planner = KeyframePlanner(robot, read_keyframes(path), path.name)
        plan = planner.plan()
        check_limits(planner, plan)
        return plan

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        plan = self._plan(context.robot)
        context.posture.follow(plan.posture, _BLEND)
        context.com.follow(plan.com, _BLEND)
        context.torso.follow(plan.torso, _BLEND)
        context.pelvis.follow(plan.pelvis, _BLEND)
        for side, place in plan.places.items():
            context.hands.follow(side, place)
        yield from context.wait(plan.duration + self.hold)
        yield from context.go_home()
