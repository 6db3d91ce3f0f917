"""Drawing commands in meshcat's message format: three.js objects as plain dictionaries.

Meshcat's Python package builds the same dictionaries, but takes half a second to import and has no
meshes with normals. The format is documented in the README of meshcat's viewer.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import umsgpack  # type: ignore[import-untyped]

Json = dict[str, Any]
Colour = tuple[float, float, float, float]

_IDENTITY = np.eye(4)
_counter = itertools.count(1)
# three.js draws cylinders and cones along y, URDF along z.
Y_TO_Z = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
# MessagePack extension codes that meshcat's page decodes to typed arrays.
_TYPED = {"i2": ("Int16Array", 0x13), "u2": ("Uint16Array", 0x14), "u4": ("Uint32Array", 0x16)}
_FLOAT32 = ("Float32Array", 0x17)


def rgb(text: str, opacity: float = 1.0) -> Colour:
    """Return `#rrggbb` as red, green, blue and opacity, 0 to 1."""
    return (int(text[1:3], 16) / 255, int(text[3:5], 16) / 255, int(text[5:7], 16) / 255, opacity)


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
    clear = opacity < 1.0
    # A translucent symbol must not hide what is drawn after it.
    return {
        "type": kind,
        "color": number,
        "side": 2,
        "opacity": opacity,
        "transparent": clear,
        "depthWrite": not clear,
        **more,
    }


def box(x: float, y: float, z: float) -> Json:
    """Return a centred box with the given edge lengths, m."""
    return {"type": "BoxGeometry", "width": x, "height": y, "depth": z}


def sphere(radius: float, segments: int = 24) -> Json:
    """Return a sphere with the given radius, m."""
    return {
        "type": "SphereGeometry",
        "radius": radius,
        "widthSegments": segments,
        "heightSegments": segments,
    }


def cylinder(radius: float, length: float, top: float | None = None, segments: int = 24) -> Json:
    """Return a centred cylinder along y, m; `top` is the radius at +y (0 makes a cone)."""
    return {
        "type": "CylinderGeometry",
        "radiusTop": radius if top is None else top,
        "radiusBottom": radius,
        "height": length,
        "radialSegments": segments,
    }


def ring(inner: float, outer: float) -> Json:
    """Return a flat ring in the x-y plane, radii in m."""
    return {"type": "RingGeometry", "innerRadius": inner, "outerRadius": outer, "thetaSegments": 40}


def triangles(vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray | None = None) -> Json:
    """Return a triangle mesh: (n, 3) vertices, m; (m, 3) indices; (n, 3) unit normals."""
    index = np.asarray(faces).astype("<u2" if len(vertices) < 65536 else "<u4")
    attributes = {"position": _array(np.asarray(vertices, dtype="<f4"))}
    if normals is not None:
        attributes["normal"] = _array(np.rint(normals * 32767).astype("<i2"), normalized=True)
    return {
        "type": "BufferGeometry",
        "data": {"attributes": attributes, "index": _array(index.reshape(-1))},
    }


def _array(x: np.ndarray, normalized: bool = False) -> Json:
    name, code = _TYPED.get(x.dtype.str[1:], _FLOAT32)
    return {
        "itemSize": x.shape[1] if x.ndim == 2 else 1,
        "type": name,
        "array": umsgpack.Ext(code, np.ascontiguousarray(x).tobytes()),
        "normalized": normalized,
    }


def floats(x: np.ndarray) -> Any:
    """Return numbers as a typed array that meshcat's page decodes without a copy."""
    return umsgpack.Ext(_FLOAT32[1], np.ascontiguousarray(x, dtype="<f4").tobytes())


def mesh(geometry: Json, material: Json, matrix: np.ndarray = _IDENTITY, order: int = 0) -> Json:
    """Return a three.js mesh: an object to draw.

    Args:
        geometry: Its shape.
        material: Its material.
        matrix: Its pose in its node, shape (4, 4).
        order: Objects with a higher order are drawn after those with a lower one.
    """
    name = f"{next(_counter):x}"
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": "g" + name, **geometry}],
        "materials": [{"uuid": "m" + name, **material}],
        "object": {
            "uuid": "o" + name,
            "type": "Mesh",
            "geometry": "g" + name,
            "material": "m" + name,
            "renderOrder": order,
            "matrix": np.asarray(matrix, dtype=float).T.ravel().tolist(),
        },
    }


def set_object(path: str, thing: Json) -> bytes:
    """Return the command that sets the object at a path of the scene."""
    return _packed({"type": "set_object", "path": path, "object": thing})


def set_animation(animations: Sequence[Json]) -> bytes:
    """Return the command that plays animation clips in a loop."""
    options = {"play": True, "repetitions": float("inf")}
    return _packed({"type": "set_animation", "animations": list(animations), "options": options})


def _packed(command: Json) -> bytes:
    return bytes(umsgpack.packb(command))
