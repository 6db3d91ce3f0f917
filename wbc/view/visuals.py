"""The shapes that a robot is drawn with: its visual shapes, or the best substitute."""

from __future__ import annotations

import logging
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.view.colours import BARE, faded
from wbc.view.objects import Json, cylinder, matte, mesh, sphere
from wbc.view.shapes import bodies

if TYPE_CHECKING:
    from wbc.robot import Robot

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class RobotVisuals:
    """The shapes that a robot is drawn with.

    Attributes:
        shapes: Maps each joint index to its shapes, placed in joint axes.
        source: Note on the origin of substitutes; empty for visual shapes.
        top: Height of the highest point above the soles in the nominal posture, m.
    """

    shapes: dict[int, list[Json]]
    source: str
    top: float


def visuals_of(robot: Robot) -> RobotVisuals:
    """Return the visual shapes or, per joint, collision shapes or an inertia ellipsoid."""
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    heights = [float(frame.translation[2]) for frame in data.oMf]
    shapes: dict[int, list[Json]] = defaultdict(list)
    for kind in ("visual", "collision"):
        geometry = _geometry(robot, kind)
        for thing in geometry.geometryObjects if geometry is not None else ():
            made = bodies(thing)
            shapes[int(thing.parentJoint)] += made
            if made:
                heights.append(_top(data.oMi[thing.parentJoint] * thing.placement, thing.geometry))
        if shapes:
            break
    if kind == "visual":
        return RobotVisuals(dict(shapes), "", max(heights))
    bare = [j for j in range(1, model.njoints) if j not in shapes]
    for joint in bare:
        shapes[joint] = ellipsoid(model.inertias[joint])
        shapes[joint] += _bones(model, joint)
    source = "collision shapes" if len(bare) < model.njoints - 1 else ""
    source += (" and " if source and bare else "") + ("inertias" if bare else "")
    logger.info("robot '%s' has no visual shapes: drawn from its %s", robot.name, source)
    return RobotVisuals(dict(shapes), f"drawn from its {source}", max(heights))


def _geometry(robot: Robot, kind: str) -> pin.GeometryModel | None:
    try:
        return robot.visual_model if kind == "visual" else robot.collision_model
    except RobotDescriptionError as error:
        logger.warning("%s", error)
        return None


def ellipsoid(inertia: pin.Inertia) -> list[Json]:
    """Return the solid ellipsoid of uniform density with the given mass and inertia.

    Its semi-axes obey `a² = 5 (I_yy + I_zz − I_xx) / (2 m)` along each principal axis; a physically
    impossible inertia is drawn as the closest possible one.
    """
    mass = float(inertia.mass)
    if not mass > 1e-6:
        return []
    moments, axes = np.linalg.eigh(inertia.inertia)
    squares = 2.5 * (moments.sum() - 2.0 * moments) / mass
    radii = np.sqrt(np.maximum(squares, 0.008**2))
    matrix = np.eye(4)
    matrix[:3, :3] = axes * (radii * np.sign(np.linalg.det(axes)))
    matrix[:3, 3] = inertia.lever
    return [mesh(sphere(1.0), matte(faded(BARE, 0.85)), matrix)]


def _bones(model: pin.Model, joint: int) -> list[Json]:
    """Return rods from a joint to its child joints."""
    rods = []
    for child in model.children[joint]:
        end = model.jointPlacements[child].translation
        length = float(np.linalg.norm(end))
        if length > 1e-3:
            matrix = np.eye(4)
            matrix[:3, :3] = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), end).matrix()
            matrix[:3, 3] = 0.5 * end
            rods.append(mesh(cylinder(0.012, length, segments=12), matte(BARE), matrix))
    return rods


def _top(placement: pin.SE3, shape: object) -> float:
    shape.computeLocalAABB()  # type: ignore[attr-defined]
    bounds = shape.aabb_local  # type: ignore[attr-defined]
    centre, half = 0.5 * (bounds.max_ + bounds.min_), 0.5 * (bounds.max_ - bounds.min_)
    up = placement.rotation[2]
    return float(placement.translation[2] + up @ centre + np.abs(up) @ half)
