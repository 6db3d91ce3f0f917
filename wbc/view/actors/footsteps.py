"""Footsteps: planned ones as bright outlines, completed ones as faint outlines."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.robot import Sole
from wbc.view.actors.actor import (
    Actor,
    Proportions,
    SceneInput,
    SceneNode,
    hide,
    put_pose,
    put_yaw,
)
from wbc.view.colours import LEFT, RIGHT, faded
from wbc.view.objects import Colour, Json, flat, mesh, triangles

_PLANNED = 8  # per side
_MADE = 12
_LIFT_PLANNED = np.array([0.0, 0.0, 0.002])
_LIFT_MADE = np.array([0.0, 0.0, 0.001])
#: Share of the weight above which a sole has touched down; below half of it, it has lifted off.
_LANDED = 0.05
#: Distance of a loaded sole from its last footprint, m, that shows a touchdown between frames.
_MOVED = 0.03


class FootstepsActor(Actor):
    """Outlines of the soles on the ground, coloured by side.

    A step is completed when the sole is loaded; without contact wrenches in the snapshots only
    planned steps are drawn.
    """

    def __init__(self, soles: Sequence[Sole], proportions: Proportions) -> None:
        self._soles = {sole.name: sole for sole in soles}
        self._weight = proportions.weight
        self._planned: dict[str, range] = {}
        self._made: dict[str, range] = {}
        self.nodes = []
        for sole in soles:
            colour = RIGHT if sole.side == "right" else LEFT
            self._planned[sole.side] = self._prints(sole, _PLANNED, colour, 0.22)
            self._made[sole.name] = self._prints(sole, _MADE, faded(colour, 0.35), 0.10)
        self.restart()

    def _prints(self, sole: Sole, count: int, colour: Colour, fill: float) -> range:
        kind = "made" if colour[3] < 1.0 else "planned"
        first = len(self.nodes)
        for i in range(count):
            parts = (
                mesh(outline(sole), flat(colour), order=3),
                mesh(area(sole), flat(faded(colour, fill)), order=1),
            )
            self.nodes.append(SceneNode(f"footsteps/{kind}_{sole.side}_{i}", parts))
        return range(first, first + count)

    def restart(self) -> None:
        self._loaded = dict.fromkeys(self._soles, False)
        self._history: dict[str, deque[pin.SE3]] = {
            name: deque(maxlen=_MADE) for name in self._soles
        }

    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        hide(poses)
        steps = scene_input.snapshot.contact_plan.footsteps
        for side, rows in self._planned.items():
            for i, step in zip(rows, (s for s in steps if s.side == side), strict=False):
                put_yaw(poses[i], step.position + _LIFT_PLANNED, step.yaw)
        for name, rows in self._made.items():
            self._remember(name, scene_input)
            for i, placement in zip(rows, self._history[name], strict=False):
                put_pose(poses[i], placement)
                poses[i, 0:3] += _LIFT_MADE

    def _remember(self, name: str, scene_input: SceneInput) -> None:
        if name not in scene_input.contacts or name not in scene_input.soles:
            self._loaded[name] = False
            return
        load = scene_input.contacts[name][1][2] / self._weight
        placement, history = scene_input.soles[name], self._history[name]
        if load > _LANDED:
            seen = history[-1].translation if history else np.full(3, np.inf)
            # Frames may be dropped, among them those with the sole in the air.
            moved = np.linalg.norm(placement.translation[:2] - seen[:2]) > _MOVED
            if moved:
                history.append(placement.copy())
            elif history and not self._loaded[name]:
                history[-1] = placement.copy()
            self._loaded[name] = True
        elif load < 0.5 * _LANDED:
            self._loaded[name] = False


def outline(sole: Sole, width: float = 0.006) -> Json:
    """Return an outline of the sole's size, with a tip at the front; `width` in m."""
    x, y = sole.half_length, sole.half_width
    outer = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
    inner = outer - np.sign(outer) * width
    tip = np.array([[x + 0.35 * y, 0.0], [x, 0.3 * y], [x, -0.3 * y]])
    faces = [(i, (i + 1) % 4, 4 + (i + 1) % 4) for i in range(4)]
    faces += [(i, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    return _level(np.concatenate([outer, inner, tip]), np.array([*faces, (8, 9, 10)]))


def area(sole: Sole) -> Json:
    """Return a rectangle of the sole's size."""
    x, y = sole.half_length, sole.half_width
    corners = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
    return _level(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def _level(points: np.ndarray, faces: np.ndarray) -> Json:
    vertices = np.column_stack([points, np.zeros(len(points))])
    return triangles(vertices, faces, np.tile([0.0, 0.0, 1.0], (len(points), 1)))
