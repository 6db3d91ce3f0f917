"""The base class of actors, and helpers that set the poses of nodes.

An actor creates its objects once and afterwards only moves, scales and hides them: a pose is
`[x y z, qx qy qz qw, sx sy sz]`, and a scale of zero hides a node. The same scene can therefore
feed a live page (a few kB per frame) and a recording (an array of poses).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.runtime.snapshot import Snapshot
from wbc.view.objects import Json

_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class SceneNode:
    """A node of the scene tree, with objects that move together.

    Attributes:
        path: Path in the tree, separated by `/`.
        objects: The objects; none for a node that the page creates.
        smooth: Whether the page may interpolate between two poses. False for objects that
            are reused at another place, to which they must jump.
    """

    path: str
    objects: tuple[Json, ...]
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
        nodes: Its nodes, in the order of the rows that `set_poses` writes.
    """

    nodes: list[SceneNode]

    @abstractmethod
    def set_poses(self, scene_input: SceneInput, poses: np.ndarray) -> None:
        """Write the poses of the nodes, shape (len(nodes), 10), over the previous ones."""

    def restart(self) -> None:  # noqa: B027  most actors have no history
        """Clear the history because a new run begins."""


def copies(path: str, count: int, *objects: Json) -> list[SceneNode]:
    """Return nodes with the same objects, whose paths end with their numbers."""
    return [SceneNode(f"{path}{i}", objects) for i in range(count)]


def set_position(pose: np.ndarray, position: np.ndarray, yaw: float = 0.0) -> None:
    """Place a node at a position (m), rotated about the vertical by `yaw` (rad); hide it if NaN."""
    if not np.isfinite(position).all():
        hide(pose)
        return
    pose[0:3] = position
    pose[3:7] = (0.0, 0.0, np.sin(0.5 * yaw), np.cos(0.5 * yaw))
    pose[7:10] = 1.0


def set_placement(pose: np.ndarray, placement: pin.SE3) -> None:
    """Place a node at a placement in the world."""
    pose[0:7] = pin.SE3ToXYZQUAT(placement)
    pose[7:10] = 1.0


def stretch(pose: np.ndarray, start: np.ndarray, end: np.ndarray) -> None:
    """Stretch a centred object of one metre length along z between two points, m."""
    vector = end - start
    length = float(np.sqrt(vector @ vector))
    if not length > 1e-6:  # also when it is NaN
        hide(pose)
        return
    pose[0:3] = 0.5 * (start + end)
    pose[3:7] = pin.Quaternion.FromTwoVectors(_Z, vector).coeffs()
    pose[7:10] = (1.0, 1.0, length)


def hide(poses: np.ndarray) -> None:
    """Hide nodes without moving them."""
    poses[..., 7:10] = 0.0
