"""Converts Pinocchio's geometry objects to drawable objects."""

from __future__ import annotations

import logging
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from wbc.view.collada import Part, read_collada
from wbc.view.colours import BARE
from wbc.view.objects import Y_TO_Z, Colour, Json, box, cylinder, matte, mesh, sphere, triangles
from wbc.view.shading import creased

logger = logging.getLogger(__name__)

#: Darkest colour that is drawn: shading is invisible on pure black.
_DARKEST = 0.25


def bodies(thing: pin.GeometryObject) -> list[Json]:
    """Return the objects that draw a geometry object, placed in joint axes.

    The list is empty for unbounded shapes (planes) and unsupported types.
    """
    place = thing.placement.homogeneous
    colour = _colour(thing)
    shape = thing.geometry
    if isinstance(shape, coal.BVHModelBase):
        return [_part(part, place, colour) for part in _parts(thing)]
    if isinstance(shape, coal.Convex):
        points = np.asarray(shape.points())
        faces = _indices(shape.polygons, shape.num_polygons)
        return [_part(Part(points, faces, None), place, colour)]
    made = _primitive(shape)
    if made is None:
        logger.warning("'%s' is a %s, which is not drawn", thing.name, type(shape).__name__)
        return []
    geometry, matrix = made
    return [mesh(geometry, matte(colour), place @ matrix)]


def _primitive(shape: coal.CollisionGeometry) -> tuple[Json, np.ndarray] | None:
    if isinstance(shape, coal.Box):
        return box(*(2.0 * shape.halfSide)), np.eye(4)
    if isinstance(shape, coal.Sphere):
        return sphere(shape.radius), np.eye(4)
    if isinstance(shape, coal.Ellipsoid):
        return sphere(1.0), np.diag([*shape.radii, 1.0])
    if isinstance(shape, coal.Cylinder):
        return cylinder(shape.radius, 2.0 * shape.halfLength, segments=36), Y_TO_Z
    if isinstance(shape, coal.Cone):
        return cylinder(shape.radius, 2.0 * shape.halfLength, top=0.0, segments=36), Y_TO_Z
    if isinstance(shape, coal.Capsule):
        return capsule(shape.radius, 2.0 * shape.halfLength), np.eye(4)
    return None


def capsule(radius: float, length: float, segments: int = 32) -> Json:
    """Return a cylinder along z with hemispheres at its ends, m; `length` is without them."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, segments // 2)
    ends = np.where(angles < 0, -0.5, 0.5) * length
    turn = np.linspace(0.0, 2.0 * np.pi, segments, endpoint=False)
    rim, up = np.cos(angles), np.sin(angles)
    normals = np.stack(
        [np.outer(rim, np.cos(turn)), np.outer(rim, np.sin(turn)), np.outer(up, np.ones(segments))],
        axis=2,
    )
    points = radius * normals
    points[..., 2] += ends[:, None]
    row = np.arange(len(angles) - 1)[:, None] * segments
    here, there = np.arange(segments), (np.arange(segments) + 1) % segments
    a, b, c, d = (row + here, row + there, row + segments + there, row + segments + here)
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return triangles(points.reshape(-1, 3), faces, normals.reshape(-1, 3))


def _parts(thing: pin.GeometryObject) -> list[Part]:
    path = Path(thing.meshPath)
    if path.suffix.lower() == ".dae":
        try:
            scale = np.asarray(thing.meshScale).reshape(3)
            return [Part(p.vertices * scale, p.faces, p.colour) for p in read_collada(path)]
        except (OSError, ValueError) as error:
            logger.warning("%s is drawn without the colours of its file: %s", path, error)
    shape = thing.geometry
    return [Part(np.asarray(shape.vertices()), _indices(shape.tri_indices, shape.num_tris), None)]


def _indices(face: object, count: int) -> np.ndarray:
    call = face if callable(face) else None
    assert call is not None
    return np.array([(t[0], t[1], t[2]) for t in map(call, range(count))], dtype=int)


def _part(part: Part, place: np.ndarray, colour: Colour) -> Json:
    vertices, faces, normals = creased(part.vertices, part.faces)
    return mesh(triangles(vertices, faces, normals), matte(_visible(part.colour or colour)), place)


def _colour(thing: pin.GeometryObject) -> Colour:
    red, green, blue, opacity = (float(c) for c in thing.meshColor)
    if not thing.overrideMaterial and not thing.meshPath.lower().endswith(".dae"):
        return BARE
    return _visible((red, green, blue, opacity if opacity > 0.0 else 1.0))


def _visible(colour: Colour) -> Colour:
    red, green, blue, opacity = colour
    lift = max(0.0, _DARKEST - max(red, green, blue))
    return (red + lift, green + lift, blue + lift, opacity)
