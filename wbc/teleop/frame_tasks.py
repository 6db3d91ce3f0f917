"""Tasks that hold links relative to the robot, added and removed while it stands or walks."""

from __future__ import annotations

import numpy as np

from wbc.motions import MotionPlayer
from wbc.motions.engine.hands import base_velocity, frame_of_hands, turn_rate
from wbc.tasks import OrientationTask, PositionTask
from wbc.teleop.commands import FrameTaskCommand

MAX_WEIGHT = 1000.0
_KP = 100.0  # 1/s²


class FrameTasks:
    """The added tasks. Each holds a link in the base frame, with the axes of the heading.

    Args:
        player: the controller to whose tasks they are added.
    """

    def __init__(self, player: MotionPlayer) -> None:
        self._player = player
        self._held: dict[tuple[str, str], _HeldFrame] = {}

    def set(self, command: FrameTaskCommand) -> None:
        """Add a task, set its weight, or remove it."""
        key, walker = (command.frame, command.kind), self._player.walker
        held = self._held.get(key)
        if command.weight <= 0.0:
            if held is not None:
                walker.controller.remove(held.task)
                del self._held[key]
        elif held is None:
            self._held[key] = _HeldFrame(self._player, command)
        else:
            held.task.weight = command.weight

    def advance(self) -> None:
        """Set the targets of the next tick."""
        for held in self._held.values():
            held.advance()

    def clear(self) -> None:
        """Remove all tasks: a run begins."""
        for held in self._held.values():
            self._player.walker.controller.remove(held.task)
        self._held.clear()


class _HeldFrame:
    """A link that is held, with its task."""

    def __init__(self, player: MotionPlayer, command: FrameTaskCommand) -> None:
        self._walker = walker = player.walker
        self._frame = command.frame
        origin, axes = frame_of_hands(walker, "base")
        now = walker.kinematics.frame(command.frame)
        self._place, self._rotation = axes.T @ (now.translation - origin), axes.T @ now.rotation
        kind = PositionTask if command.kind == "position" else OrientationTask
        self.task: PositionTask | OrientationTask = walker.controller.add(
            kind(
                command.frame,
                weight=command.weight,
                kp=_KP,
                name=f"{command.frame} {command.kind}, held",
            )
        )
        self.advance()

    def advance(self) -> None:
        """Set the target to where the robot has moved."""
        origin, axes = frame_of_hands(self._walker, "base")
        if isinstance(self.task, PositionTask):
            lever = axes @ self._place
            self.task.target = origin + lever
            self.task.velocity = base_velocity(self._walker, lever)
        else:
            self.task.target = axes @ self._rotation
            self.task.velocity = np.array([0.0, 0.0, turn_rate(self._walker)])
