"""The shapes that a robot is drawn with: its visual shapes, or the best substitute."""

from __future__ import annotations

import logging
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from trimesh import Trimesh, creation

from wbc.errors import RobotDescriptionError
from wbc.view.colours import BARE, Colour, faded
from wbc.view.objects import sphere
from wbc.view.shapes import shapes_of

if TYPE_CHECKING:
    from wbc.robot import Robot

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class RobotVisuals:
    """The shapes that a robot is drawn with.

    Attributes:
        shapes: Maps each joint index to its shapes, in joint axes, m, and their colours.
        source: Note on the origin of substitutes; empty for visual shapes.
        top: Height of the highest point above the soles in the nominal posture, m.
    """

    shapes: dict[int, list[tuple[Trimesh, Colour]]]
    source: str
    top: float


def visuals_of(robot: Robot) -> RobotVisuals:
    """Return the visual shapes or, per joint, collision shapes or an inertia ellipsoid."""
    shapes, source = _geometry_shapes(robot, "visual"), ""
    if not shapes:
        shapes, source = _substitutes(robot)
        logger.info("robot '%s' has no visual shapes: %s", robot.name, source)
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    heights = [float(frame.translation[2]) for frame in data.oMf]
    for joint, pairs in shapes.items():
        up, height = data.oMi[joint].rotation[2], data.oMi[joint].translation[2]
        heights += [float(height + (shape.vertices @ up).max()) for shape, _ in pairs]
    return RobotVisuals(shapes, source, max(heights))


def _geometry_shapes(robot: Robot, kind: str) -> dict[int, list[tuple[Trimesh, Colour]]]:
    try:
        geometry = robot.visual_model if kind == "visual" else robot.collision_model
    except RobotDescriptionError as error:
        logger.warning("%s", error)
        return {}
    shapes: dict[int, list[tuple[Trimesh, Colour]]] = defaultdict(list)
    for geometry_object in geometry.geometryObjects:
        if pairs := shapes_of(geometry_object):
            shapes[int(geometry_object.parentJoint)] += pairs
    return shapes


def _substitutes(robot: Robot) -> tuple[dict[int, list[tuple[Trimesh, Colour]]], str]:
    """Return collision shapes, ellipsoids and rods by joint, and a note on their origin."""
    model = robot.model
    shapes = _geometry_shapes(robot, "collision")
    sources = ["collision shapes"] if shapes else []
    bare = [joint for joint in range(1, model.njoints) if joint not in shapes]
    for joint in bare:
        inertia = model.inertias[joint]
        shapes[joint] = [(ellipsoid(inertia), faded(BARE, 0.85))] if inertia.mass > 1e-6 else []
        shapes[joint] += [(rod, BARE) for rod in _rods(model, joint)]
    sources += ["inertias"] if bare else []
    return shapes, f"drawn from its {' and '.join(sources)}"


def ellipsoid(inertia: pin.Inertia) -> Trimesh:
    """Return the solid ellipsoid of uniform density with the given mass and inertia.

    Its semi-axes obey `a² = 5 (I_yy + I_zz − I_xx) / (2 m)` along each principal axis; a physically
    impossible inertia is drawn as the closest possible one.
    """
    moments, axes = np.linalg.eigh(inertia.inertia)
    squares = 2.5 * (moments.sum() - 2.0 * moments) / inertia.mass
    matrix = np.eye(4)
    matrix[:3, :3] = axes * np.sqrt(np.maximum(squares, 0.008**2)) * np.linalg.det(axes)
    matrix[:3, 3] = inertia.lever
    return sphere().apply_transform(matrix)


def _rods(model: pin.Model, joint: int) -> list[Trimesh]:
    """Return rods from a joint to its child joints."""
    ends = [model.jointPlacements[child].translation for child in model.children[joint]]
    return [
        creation.cylinder(0.012, segment=[np.zeros(3), end])
        for end in ends
        if np.linalg.norm(end) > 1e-3
    ]
