"""Drawing commands in meshcat's message format: three.js objects as plain dictionaries.

Meshcat's own classes build such dictionaries, too, but have no vertex normals, drawing order or
depth test. The format is documented in the README of meshcat's viewer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import umsgpack  # type: ignore[import-untyped]
from trimesh import Trimesh, creation
from trimesh.graph import connected_component_labels

from wbc.view.colours import Colour

Json = dict[str, Any]

#: Edges at which faces meet at a larger angle are sharp, rad.
CREASE = np.deg2rad(35.0)
# MessagePack extension codes that meshcat's page decodes to typed arrays.
_TYPES = {
    "i2": ("Int16Array", 0x13),
    "u2": ("Uint16Array", 0x14),
    "u4": ("Uint32Array", 0x16),
    "f4": ("Float32Array", 0x17),
}


def matte(colour: Colour) -> Json:
    """Return a lit material, for physical objects."""
    return _material("MeshPhongMaterial", colour, shininess=35, specular=0x333333)


def flat(colour: Colour) -> Json:
    """Return an unlit material, for symbols that are identified by their colour."""
    return _material("MeshBasicMaterial", colour)


def see_through(colour: Colour, lit: bool = False) -> Json:
    """Return a material that is drawn over objects in front of it."""
    return {**(matte if lit else flat)(colour), "depthTest": False, "transparent": True}


def _material(kind: str, colour: Colour, **more: object) -> Json:
    red, green, blue, opacity = (min(max(c, 0.0), 1.0) for c in colour)
    number = (round(red * 255) << 16) + (round(green * 255) << 8) + round(blue * 255)
    translucent = opacity < 1.0
    # A translucent symbol must not hide what is drawn after it.
    return {
        "type": kind,
        "color": number,
        "side": 2,
        "opacity": opacity,
        "transparent": translucent,
        "depthWrite": not translucent,
        **more,
    }


def sphere(radius: float = 1.0, segments: int = 16) -> Trimesh:
    """Return a sphere with the given radius, m."""
    return creation.uv_sphere(radius, count=(segments, segments))


def drawable(shape: Trimesh, material: Json, order: int = 0) -> Json:
    """Return a three.js mesh: an object to draw.

    Args:
        shape: Its shape, m, in the axes of its node.
        material: Its material.
        order: Objects with a higher order are drawn after those with a lower one.
    """
    shape = creased(shape)
    attributes = {
        "position": _array(shape.vertices, "f4"),
        "normal": _array(np.rint(shape.vertex_normals * 32767), "i2", normalized=True),
    }
    index = _array(shape.faces.reshape(-1, 1), "u2" if len(shape.vertices) < 1 << 16 else "u4")
    data = {"attributes": attributes, "index": index}
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": "geometry", "type": "BufferGeometry", "data": data}],
        "materials": [{"uuid": "material", **material}],
        "object": {
            "uuid": "object",
            "type": "Mesh",
            "geometry": "geometry",
            "material": "material",
            "renderOrder": order,
        },
    }


def creased(shape: Trimesh) -> Trimesh:
    """Return a copy whose normals render curved surfaces smooth and edges sharp.

    Equal vertices are merged, and then split between the patches of faces that sharp edges
    separate. `trimesh.graph.smooth_shade` does the same but takes seconds for meshes with many
    small patches.
    """
    merged = Trimesh(shape.vertices, shape.faces)
    merged.update_faces(merged.nondegenerate_faces(height=None))
    smooth = merged.face_adjacency[merged.face_adjacency_angles < CREASE]
    patches = connected_component_labels(smooth, node_count=len(merged.faces))
    corners = merged.faces * len(merged.faces) + patches[:, None]
    split, faces = np.unique(corners, return_inverse=True)
    vertices = merged.vertices[split // max(len(merged.faces), 1)]
    return Trimesh(vertices, faces.reshape(-1, 3), process=False)


def _array(rows: np.ndarray, kind: str, normalized: bool = False) -> Json:
    name, code = _TYPES[kind]
    data = umsgpack.Ext(code, np.ascontiguousarray(rows, dtype=f"<{kind}").tobytes())
    return {"itemSize": rows.shape[1], "type": name, "array": data, "normalized": normalized}


def set_object(path: str, description: Json) -> bytes:
    """Return the command that sets the object at a path of the scene."""
    return bytes(umsgpack.packb({"type": "set_object", "path": path, "object": description}))
