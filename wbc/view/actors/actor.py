"""The base class of actors, and helpers that set the poses of nodes.

An actor creates its objects once and afterwards only moves, scales and hides them: a pose is
`[x y z, qx qy qz qw, sx sy sz]`, and a scale of zero hides a node. The same scene can therefore
feed a live page (a few kB per frame) and an animation (keyframe tracks).
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
    """A node of the scene tree, with objects that move together.

    Attributes:
        path: Path in the tree, separated by `/`.
        parts: The objects; none for a node that meshcat's page creates.
        smooth: Whether an animation may interpolate between two poses. False for objects that
            are reused at another place, to which they must jump.
    """

    path: str
    parts: tuple[Json, ...]
    smooth: bool = False


@dataclass(frozen=True)
class Proportions:
    """Dimensions of the robot to which drawn symbols are scaled.

    Attributes:
        com_height: Height of the standing robot's centre of mass above its soles, m.
        top: Height of the standing robot above its soles, m.
        weight: Weight of the robot, N.
    """

    com_height: float
    top: float
    weight: float

    @property
    def unit(self) -> float:
        """Scale of the drawn symbols; 1 for a robot of human size."""
        return self.com_height / 0.9


@dataclass(frozen=True, eq=False)
class SceneInput:
    """A snapshot with the kinematics needed to draw it.

    Attributes:
        snapshot: Snapshot to draw.
        data: Pinocchio data with joint and frame placements at `snapshot.q`.
        contacts: Maps each contact to its placement in the world and its wrench in contact
            axes, N and N·m, shape (6,).
        soles: Maps each sole to its placement in the world.
        com: Centre of mass, m, world frame, shape (3,).
        base: Position of the root joint, m, world frame, shape (3,).
        dt: Time since the previous input, s; 0 for the first.
    """

    snapshot: Snapshot
    data: pin.Data
    contacts: dict[str, tuple[pin.SE3, np.ndarray]]
    soles: dict[str, pin.SE3]
    com: np.ndarray
    base: np.ndarray
    dt: float


class Actor(ABC):
    """A part of the scene, such as the robot or the contact forces.

    Attributes:
        nodes: Its nodes, in the order of the rows that `place` writes.
    """

    nodes: list[SceneNode]

    @abstractmethod
    def place(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        """Write the poses of the nodes, shape (len(nodes), 10), over the previous ones."""

    def restart(self) -> None:  # noqa: B027  most actors have no history
        """Clear the history because a new run begins."""


def put(row: np.ndarray, position: np.ndarray, scale: float = 1.0) -> None:
    """Place a node upright at a position, m; hide it if the position is NaN."""
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
    """Place a node at a position (m), rotated about the world's z axis by `yaw` (rad)."""
    put(row, position)
    row[5], row[6] = np.sin(0.5 * yaw), np.cos(0.5 * yaw)


def stretch(row: np.ndarray, start: np.ndarray, end: np.ndarray, thickness: float = 1.0) -> None:
    """Stretch a centred object of one metre length along y between two points, m."""
    way = end - start
    length = float(np.sqrt(way @ way))
    if not length > 1e-6:  # also when it is NaN
        hide(row)
        return
    row[0:3] = 0.5 * (start + end)
    row[3:7] = turn_y_to(way / length)
    row[7:10] = (thickness, length, thickness)


def turn_y_to(axis: np.ndarray) -> tuple[float, float, float, float]:
    """Return the smallest rotation of the y axis to a unit axis, as a quaternion x y z w."""
    x, y, z = (float(a) for a in axis)
    if y < -1.0 + 1e-9:
        return (1.0, 0.0, 0.0, 0.0)
    norm = float(np.sqrt(z * z + x * x + (1.0 + y) ** 2))
    return (z / norm, 0.0, -x / norm, (1.0 + y) / norm)


def hide(rows: np.ndarray) -> None:
    """Hide nodes without moving them, so that an animation does not move them when shown again."""
    rows[..., 7:10] = 0.0
