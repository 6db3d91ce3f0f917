"""The base of everything that is drawn, and the arithmetic of poses.

An actor makes its bodies once and afterwards only moves, stretches and hides
them: a pose is `[x y z, qx qy qz qw, sx sy sz]`, and a scale of zero hides. That
is what lets one scene feed a live page (a few kB per frame) and an animation
(tracks of numbers) alike.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.runtime.snapshot import Snapshot
from wbc.view.objects import Json


@dataclass(frozen=True, eq=False)
class SceneNode:
    """A place in the scene's tree, with bodies that move together.

    Attributes:
        path: `/`-separated.
        parts: the bodies; none for a node that meshcat's page already has.
        smooth: an animation may interpolate between two poses. False for bodies
            that are used again elsewhere and would fly across the scene.
    """

    path: str
    parts: tuple[Json, ...]
    smooth: bool = False


@dataclass(frozen=True)
class Proportions:
    """Sizes that the marks are drawn in proportion to.

    Attributes:
        com_height: of the standing robot's centre of mass above its soles, m.
        top: of the standing robot above its soles, m.
        weight: N.
    """

    com_height: float
    top: float
    weight: float

    @property
    def unit(self) -> float:
        """1 for a robot of human size."""
        return self.com_height / 0.9


@dataclass(frozen=True, eq=False)
class SceneInput:
    """A snapshot with the kinematics that drawing it needs.

    Attributes:
        snapshot: what is shown.
        data: `forwardKinematics` and frame placements of `snapshot.q`.
        contacts: name -> (placement in the world, (6,) wrench in its axes; N, N·m).
        soles: name -> placement of every sole in the world.
        com: (3,) centre of mass, m, world.
        base: (3,) position of the root joint, m, world.
        dt: time since the previous scene_input, s; 0 at the first.
    """

    snapshot: Snapshot
    data: pin.Data
    contacts: dict[str, tuple[pin.SE3, np.ndarray]]
    soles: dict[str, pin.SE3]
    com: np.ndarray
    base: np.ndarray
    dt: float


class Actor(ABC):
    """Something drawn.

    Attributes:
        nodes: its places in the scene's tree, in the order of `place`'s rows.
    """

    nodes: list[SceneNode]

    @abstractmethod
    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        """Write the poses, (len(nodes), 10), of this scene_input; they hold the previous ones."""

    def restart(self) -> None:  # noqa: B027  most actors have no history
        """Forget history: another run begins."""


def put(row: np.ndarray, position: np.ndarray, scale: float = 1.0) -> None:
    """Place a node upright; a position that is not known hides it."""
    if not np.isfinite(position).all():
        hide(row)
        return
    row[0:3] = position
    row[3:7] = (0.0, 0.0, 0.0, 1.0)
    row[7:10] = scale


def put_pose(row: np.ndarray, placement: pin.SE3) -> None:
    """Place a node at a placement in the world."""
    row[0:7] = pin.SE3ToXYZQUAT(placement)
    row[7:10] = 1.0


def put_yaw(row: np.ndarray, position: np.ndarray, yaw: float) -> None:
    """Place a node at a position, turned about the world's z."""
    put(row, position)
    row[5], row[6] = np.sin(0.5 * yaw), np.cos(0.5 * yaw)


def stretch(row: np.ndarray, start: np.ndarray, end: np.ndarray, thickness: float = 1.0) -> None:
    """Stretch a body that is one metre long along y, and centred, between two points."""
    way = end - start
    length = float(np.sqrt(way @ way))
    if not length > 1e-6:  # also when it is NaN
        hide(row)
        return
    row[0:3] = 0.5 * (start + end)
    row[3:7] = turn_y_to(way / length)
    row[7:10] = (thickness, length, thickness)


def turn_y_to(axis: np.ndarray) -> tuple[float, float, float, float]:
    """The shortest rotation of y to a unit axis, as a quaternion x y z w."""
    x, y, z = (float(a) for a in axis)
    if y < -1.0 + 1e-9:
        return (1.0, 0.0, 0.0, 0.0)
    norm = float(np.sqrt(z * z + x * x + (1.0 + y) ** 2))
    return (z / norm, 0.0, -x / norm, (1.0 + y) / norm)


def hide(rows: np.ndarray) -> None:
    """Hide a node, or several; they keep their place, so that none flies when shown again."""
    rows[..., 7:10] = 0.0
