"""Converts Pinocchio's geometry objects to coloured triangle meshes."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import trimesh
from trimesh import Trimesh, creation
from trimesh.units import unit_conversion

from wbc.view.colours import BARE, Colour
from wbc.view.objects import sphere

logger = logging.getLogger(__name__)

#: Darkest colour that is drawn: shading is invisible on pure black.
_DARKEST = 0.25


def shapes_of(geometry_object: pin.GeometryObject) -> list[tuple[Trimesh, Colour]]:
    """Return the shapes of a geometry object in joint axes, m, and their colours.

    The list is empty for unbounded shapes (planes) and unsupported types.
    """
    try:
        shapes = list(_file_shapes(geometry_object))
    except Exception as error:  # the loaders of the formats raise exceptions of many types
        logger.warning(
            "%s is drawn without the colours of its file: %s", geometry_object.meshPath, error
        )
        shapes = []
    if not shapes and (shape := _coal_shape(geometry_object.geometry)) is not None:
        shapes = [(shape, _stated_colour(geometry_object))]
    if not shapes:
        logger.warning(
            "'%s' is a %s, which is not drawn",
            geometry_object.name,
            type(geometry_object.geometry).__name__,
        )
    for shape, _ in shapes:
        shape.apply_transform(geometry_object.placement.homogeneous)
    return [(shape, _visible(colour)) for shape, colour in shapes]


def _file_shapes(geometry_object: pin.GeometryObject) -> Iterator[tuple[Trimesh, Colour]]:
    """Yield the shapes of the object's mesh file: Pinocchio keeps neither their colours nor units.

    As in ROS, a Collada file's `up_axis` does not rotate them.
    """
    path = Path(geometry_object.meshPath)
    if not path.is_file():
        return
    for shape in trimesh.load_scene(path).dump():
        if not isinstance(shape, Trimesh):
            continue
        metres = unit_conversion(shape.units, "meters") if shape.units else 1.0
        shape.apply_scale(metres * np.asarray(geometry_object.meshScale).reshape(3))
        material = getattr(shape.visual, "material", None)
        if material is None:
            yield shape, _stated_colour(geometry_object)
        else:
            red, green, blue = (float(c) / 255 for c in material.main_color[:3])
            yield shape, (red, green, blue, 1.0)


def _coal_shape(shape: Any) -> Trimesh | None:
    match shape:
        case coal.Box():
            return creation.box(2.0 * shape.halfSide)
        case coal.Sphere():
            return sphere(shape.radius)
        case coal.Ellipsoid():
            return sphere().apply_scale(shape.radii)
        case coal.Cylinder():
            return creation.cylinder(shape.radius, 2.0 * shape.halfLength)
        case coal.Cone():
            cone = creation.cone(shape.radius, 2.0 * shape.halfLength)
            return cone.apply_translation((0.0, 0.0, -shape.halfLength))
        case coal.Capsule():
            return creation.capsule(2.0 * shape.halfLength, shape.radius, count=(24, 12))
        case coal.BVHModelBase():
            return Trimesh(shape.vertices(), _indices(shape.tri_indices, shape.num_tris))
        case coal.Convex():
            return Trimesh(shape.points(), _indices(shape.polygons, shape.num_polygons))
    return None


def _indices(triangle: Any, count: int) -> np.ndarray:
    return np.array([(t[0], t[1], t[2]) for t in map(triangle, range(count))], dtype=int)


def _stated_colour(geometry_object: pin.GeometryObject) -> Colour:
    if not geometry_object.overrideMaterial:
        return BARE
    red, green, blue, opacity = (float(c) for c in geometry_object.meshColor)
    return (red, green, blue, opacity if opacity > 0.0 else 1.0)


def _visible(colour: Colour) -> Colour:
    red, green, blue, opacity = colour
    lift = max(0.0, _DARKEST - max(red, green, blue))
    return (red + lift, green + lift, blue + lift, opacity)
