"""Footsteps: planned ones as bright outlines, completed ones as faint outlines."""

from __future__ import annotations

from collections import deque

import numpy as np
import pinocchio as pin
from trimesh import Trimesh

from wbc.robot import Sole
from wbc.view.actors.actor import (
    Actor,
    Proportions,
    SceneInput,
    copies,
    hide,
    set_placement,
    set_position,
)
from wbc.view.colours import LEFT, RIGHT, Colour, faded
from wbc.view.objects import Json, drawable, flat

_PLANNED = 8
_COMPLETED = 12
_LIFT_PLANNED = 0.002  # m
_LIFT_COMPLETED = 0.001  # m
#: Share of the weight above which a sole has touched down; below half of it, it has lifted off.
_TOUCHDOWN = 0.05
#: Distance of a loaded sole from its last footprint, m, that shows a touchdown between frames.
_MOVED = 0.03


class FootstepsActor(Actor):
    """Outlines of a sole on the ground, coloured by side.

    A step is completed when the sole is loaded; without contact wrenches in the snapshots only
    planned steps are drawn.
    """

    def __init__(self, sole: Sole, proportions: Proportions) -> None:
        self._sole = sole
        self._weight = proportions.weight
        colour = RIGHT if sole.side == "right" else LEFT
        planned, completed = (
            _footprint(sole, colour, 0.22),
            _footprint(sole, faded(colour, 0.35), 0.1),
        )
        self.nodes = copies(f"footsteps/planned_{sole.side}_", _PLANNED, *planned)
        self.nodes += copies(f"footsteps/completed_{sole.side}_", _COMPLETED, *completed)
        self.restart()

    def restart(self) -> None:
        self._loaded = False
        self._completed: deque[pin.SE3] = deque(maxlen=_COMPLETED)

    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        footsteps = scene_input.snapshot.contact_plan.footsteps
        planned = [step for step in footsteps if step.side == self._sole.side]
        for pose, step in zip(poses[:_PLANNED], planned, strict=False):
            set_position(pose, step.position, step.yaw)
            pose[2] += _LIFT_PLANNED
        self._update_completed(scene_input)
        for pose, placement in zip(poses[_PLANNED:], self._completed, strict=False):
            set_placement(pose, placement)
            pose[2] += _LIFT_COMPLETED

    def _update_completed(self, scene_input: SceneInput) -> None:
        name, completed = self._sole.name, self._completed
        _, wrench = scene_input.contacts.get(name, (None, np.zeros(6)))
        load = wrench[2] / self._weight
        if load > _TOUCHDOWN:
            placement = scene_input.soles[name].copy()
            last = completed[-1].translation if completed else np.full(3, np.inf)
            # Frames may be dropped, among them those with the sole in the air.
            if np.linalg.norm(placement.translation[:2] - last[:2]) > _MOVED:
                completed.append(placement)
            elif not self._loaded:
                completed[-1] = placement
            self._loaded = True
        elif load < 0.5 * _TOUCHDOWN:
            self._loaded = False


def _footprint(sole: Sole, colour: Colour, fill: float) -> tuple[Json, Json]:
    """Return an outline of the sole's size with a tip at the front, and its filled area."""
    x, y = sole.half_length, sole.half_width
    outer = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
    inner = outer - 0.006 * np.sign(outer)
    tip = [[x + 0.35 * y, 0.0], [x, 0.3 * y], [x, -0.3 * y]]
    faces = [(i, (i + 1) % 4, 4 + (i + 1) % 4) for i in range(4)]
    faces += [(i, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    outline = _flat_shape(np.concatenate([outer, inner, tip]), [*faces, (8, 9, 10)])
    area = _flat_shape(outer, [(0, 1, 2), (0, 2, 3)])
    return (
        drawable(outline, flat(colour), order=3),
        drawable(area, flat(faded(colour, fill)), order=1),
    )


def _flat_shape(points: np.ndarray, faces: list[tuple[int, int, int]]) -> Trimesh:
    return Trimesh(np.column_stack([points, np.zeros(len(points))]), faces)
