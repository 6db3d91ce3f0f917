"""The shapes with which a robot's bodies collide: boxes, spheres, cylinders, capsules, hulls."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import coal
import numpy as np
import pinocchio as pin

from wbc.errors import RobotDescriptionError
from wbc.robot.computed_once import computed_once
from wbc.robot.packages import mesh_unit
from wbc.robot.robot_model import RobotModel
from wbc.robot.soles import Sole

_log = logging.getLogger(__name__)

#: Thickness of the sole boxes, m: thin, above the sole plane. Other shapes of a foot begin
#: above them, so that a standing foot touches the ground with its sole alone.
SOLE_THICKNESS = 0.02
#: A body without collision shapes gets a substitute from this share of the robot's mass on.
#: Lighter ones are the crosses of joints, which lie inside of their neighbours' shells.
_LEAST_MASS_SHARE = 0.02
#: Hulls thinner than this are left out, m: screens, stickers and the like.
_LEAST_THICKNESS = 1e-3
#: Hulls are simplified, for the time of a step and the size of a copy.
_MAX_VERTICES = 32
_TOLERANCE = 3e-3  # m
#: Directions in which a simplified hull reaches as far as the whole one, in principal axes.
_DIRECTIONS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])
#: Points on the rim of a cylinder and on each half of a sphere, where one is cut.
_RIM_POINTS = 16

ShapeKind = Literal["box", "sphere", "cylinder", "capsule", "hull"]
ShapeSource = Literal["collision", "visual", "inertia"]


@dataclass(frozen=True, slots=True, eq=False)
class CollisionShape:
    """A convex shape fixed to a body.

    Attributes:
        joint_id: Pinocchio joint that moves the body.
        link: the link of the description that it belongs to; the joint's name for a substitute.
        source: where it comes from: the description's collision or visual shapes, or the inertia.
        kind: its kind.
        placement: `T_joint_shape`.
        size: half sizes (box); radius (sphere); radius and half length along z (cylinder,
            capsule); nothing (hull); m.
        vertices: (n, 3) vertices of a hull in the shape's axes, m.
    """

    joint_id: int
    link: str
    source: ShapeSource
    kind: ShapeKind
    placement: pin.SE3
    size: tuple[float, ...]
    vertices: np.ndarray


@computed_once
def collision_shapes(robot: RobotModel) -> tuple[CollisionShape, ...]:
    """Return the shapes of all bodies, without the soles; computed once per robot.

    They are the description's collision shapes, meshes replaced by their convex hulls. A body
    of at least 2 % of the mass that has none gets the hulls of its visual shapes or, without
    these, the box of uniform density that has its inertia.
    """
    found = _shapes_of(robot, "collision")
    bare = _bare_bodies(robot, found)
    if bare:
        visuals = [shape for shape in _shapes_of(robot, "visual") if shape.joint_id in bare]
        found += visuals
        found += [_inertia_box(robot, joint) for joint in _bare_bodies(robot, found)]
    feet = {sole.joint_id: sole for sole in soles_of(robot)}
    kept = []
    for shape in found:
        sole = feet.get(shape.joint_id)
        above = shape if sole is None else _above_sole(shape, sole)
        if above is not None:
            kept.append(above)
    return tuple(kept)


def _bare_bodies(robot: RobotModel, shapes: list[CollisionShape]) -> list[int]:
    """Return the heavy bodies without shapes; a foot has at least its sole."""
    with_shapes = {shape.joint_id for shape in shapes} | {sole.joint_id for sole in soles_of(robot)}
    least = _LEAST_MASS_SHARE * robot.mass
    inertias = robot.model.inertias
    return [
        joint
        for joint in range(1, robot.model.njoints)
        if joint not in with_shapes and inertias[joint].mass >= least
    ]


def _shapes_of(robot: RobotModel, source: Literal["collision", "visual"]) -> list[CollisionShape]:
    try:
        geometry = (
            robot.read_geometry(pin.COLLISION) if source == "collision" else robot.visual_model
        )
    except RobotDescriptionError as error:
        _log.warning("%s", error)
        return []
    shapes = []
    for item in geometry.geometryObjects:
        link = robot.model.frames[item.parentFrame].name
        joint = int(item.parentJoint)
        unit = mesh_unit(Path(item.meshPath))
        for kind, placement, size, vertices in _convex(item):
            shapes.append(
                CollisionShape(joint, link, source, kind, placement, size, unit * vertices)
            )
    return shapes


_Convex = tuple[ShapeKind, pin.SE3, tuple[float, ...], np.ndarray]
_NO_VERTICES = np.empty((0, 3))


def _convex(item: Any) -> Iterator[_Convex]:
    """Yield the convex shape of a geometry object; nothing for one that is flat or unbounded."""
    placement, shape = item.placement, item.geometry
    match shape:
        case coal.Box():
            yield "box", placement, tuple(shape.halfSide.tolist()), _NO_VERTICES
        case coal.Sphere():
            yield "sphere", placement, (shape.radius,), _NO_VERTICES
        case coal.Cylinder():
            yield "cylinder", placement, (shape.radius, shape.halfLength), _NO_VERTICES
        case coal.Capsule():
            yield "capsule", placement, (shape.radius, shape.halfLength), _NO_VERTICES
        case coal.BVHModelBase() | coal.Convex():
            points = shape.vertices() if isinstance(shape, coal.BVHModelBase) else shape.points()
            vertices = hull_vertices(np.asarray(points, dtype=float).reshape(-1, 3))
            if len(vertices):
                yield "hull", placement, (), vertices


def hull_vertices(points: np.ndarray) -> np.ndarray:
    """Return the vertices of the convex hull of points (n, 3), or of a simpler one within it.

    The simpler hull lacks at most 3 mm of the points, or has 32 vertices: those that are farthest
    out, one after the other. A flat hull has no vertices.
    """
    if len(points) < 4:
        return _NO_VERTICES
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if float(np.ptp(points @ axes[2])) < _LEAST_THICKNESS:
        return _NO_VERTICES
    hull = _convex_hull(points)
    if hull is None:
        return _NO_VERTICES
    corners = points[hull.vertices]
    kept = sorted({int(np.argmax(corners @ way)) for way in _DIRECTIONS @ axes})
    while len(kept) < min(_MAX_VERTICES, len(corners)):
        hull = _convex_hull(corners[kept])
        if hull is None:
            return np.asarray(corners)
        outside = (hull.equations[:, :3] @ corners.T + hull.equations[:, 3:]).max(axis=0)
        farthest = int(np.argmax(outside))
        if outside[farthest] <= _TOLERANCE:
            break
        kept.append(farthest)
    return np.asarray(corners[kept])


def _convex_hull(points: np.ndarray) -> Any:
    """Return SciPy's convex hull of points (n, 3); None if they are flat."""
    from scipy.spatial import ConvexHull, QhullError  # half a second

    try:
        return ConvexHull(points)
    except QhullError:
        return None


def _inertia_box(robot: RobotModel, joint: int) -> CollisionShape:
    """Return the box of uniform density with a body's mass and inertia.

    Its half sizes obey `a² = 3 (I_yy + I_zz − I_xx) / (2 m)` along each principal axis.
    """
    inertia = robot.model.inertias[joint]
    moments, axes = np.linalg.eigh(inertia.inertia)
    squares = 1.5 * (moments.sum() - 2.0 * moments) / inertia.mass
    half = np.sqrt(np.maximum(squares, (0.5 * _LEAST_THICKNESS) ** 2))
    rotation = axes * np.array([1.0, 1.0, np.linalg.det(axes)])
    placement = pin.SE3(rotation, inertia.lever)
    name = robot.model.names[joint]
    return CollisionShape(
        joint, name, "inertia", "box", placement, tuple(half.tolist()), _NO_VERTICES
    )


def _above_sole(shape: CollisionShape, sole: Sole) -> CollisionShape | None:
    """Return the part of a foot's shape above its sole's box; None if there is none."""
    to_sole = sole.placement.inverse() * shape.placement
    points = shape_points(shape) @ to_sole.rotation.T + to_sole.translation
    if points[:, 2].min() >= SOLE_THICKNESS:
        return shape
    hull = _convex_hull(points)
    if hull is None:
        return None
    faces = points[hull.simplices]
    begin = faces.reshape(-1, 3)
    end = np.roll(faces, 1, axis=1).reshape(-1, 3)
    below, above = begin[:, 2] - SOLE_THICKNESS, end[:, 2] - SOLE_THICKNESS
    crossing = below * above < 0.0
    share = (below / np.where(crossing, below - above, 1.0))[crossing, None]
    cut = begin[crossing] + share * (end[crossing] - begin[crossing])
    vertices = hull_vertices(np.vstack([points[points[:, 2] >= SOLE_THICKNESS], cut]))
    if not len(vertices):
        return None
    return CollisionShape(
        shape.joint_id, shape.link, shape.source, "hull", sole.placement, (), vertices
    )


def shape_points(shape: CollisionShape) -> np.ndarray:
    """Return points (n, 3) whose hull is the shape, round ones as polyhedra, in its axes, m."""
    if shape.kind == "hull":
        return shape.vertices
    if shape.kind == "box":
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return np.asarray(signs * np.array(shape.size))
    radius, half_length = (*shape.size, 0.0)[:2]
    angle = np.arange(_RIM_POINTS) * (2.0 * np.pi / _RIM_POINTS)
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(_RIM_POINTS)])
    if shape.kind == "cylinder":
        rings = [radius * rim]
    else:
        elevations = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _RIM_POINTS // 2 + 1)
        rings = [radius * (np.cos(e) * rim + [0.0, 0.0, np.sin(e)]) for e in elevations]
    ends = ([0.0, 0.0, -half_length], [0.0, 0.0, half_length])
    return np.vstack([ring + end for ring in rings for end in ends])


def polyhedron_error(shape: CollisionShape) -> float:
    """Return by how much a shape may extend beyond the hull of its `shape_points`, m."""
    if shape.kind in ("hull", "box"):
        return 0.0
    cosine = float(np.cos(np.pi / _RIM_POINTS))
    return shape.size[0] * (1.0 - (cosine if shape.kind == "cylinder" else cosine * cosine))


def geometry_shapes(name: str, geometry: Any, placement: pin.SE3) -> list[CollisionShape]:
    """Return the convex shape of a geometry of coal that is fixed to the world.

    Args:
        name: what it is called.
        geometry: coal's geometry; a mesh counts as its convex hull.
        placement: in the world.

    Returns:
        One shape; none for a geometry that is flat or unbounded.
    """
    item = pin.GeometryObject(name, 0, placement, geometry)
    return [CollisionShape(0, name, "collision", *found) for found in _convex(item)]


def soles_of(robot: RobotModel) -> tuple[Sole, ...]:
    """Return the soles of a robot that walks, none of an arm."""
    return tuple(getattr(robot, "soles", ()))
