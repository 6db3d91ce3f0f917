"""A reader for Collada (.dae) meshes that keeps the colours of their parts.

Pinocchio's mesh loader returns one shape without colours, and meshcat's page takes up to 20 s to
parse the XML of a whole robot. Lines, textures, animations and skins are ignored. As in ROS, the
file's `up_axis` does not rotate the mesh.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one material.

    Attributes:
        vertices: Positions, m, axes of the file, shape (n, 3).
        faces: Vertex indices, shape (m, 3).
        colour: Red, green, blue and opacity, 0 to 1; None if the file states no colour.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colour: tuple[float, float, float, float] | None


def read_collada(path: str | Path) -> list[Part]:
    """Return the parts of the file's scene, placed in the scene's frame.

    Raises:
        OSError: The file cannot be read.
        ValueError: The file is not a Collada file, or holds no triangles.
    """
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path}: {error}") from error
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    parts = list(_Reader(root).parts())
    if not parts:
        raise ValueError(f"{path} holds no triangles")
    return parts


class _Reader:
    def __init__(self, root: ET.Element) -> None:
        self.root = root
        self.byid = {e.get("id", ""): e for e in root.iter() if e.get("id")}
        unit = root.find("asset/unit")
        self.scale = float(unit.get("meter", 1)) if unit is not None else 1.0

    def parts(self) -> Iterator[Part]:
        scene = self.root.find("library_visual_scenes/visual_scene")
        start = np.diag([self.scale, self.scale, self.scale, 1.0])
        for node in scene.findall("node") if scene is not None else ():
            yield from self._node(node, start)

    def _node(self, node: ET.Element, parent: np.ndarray) -> Iterator[Part]:
        place = parent @ _transform(node)
        for instance in node.findall("instance_geometry"):
            mesh = self._find(instance.get("url", "")).find("mesh")
            if mesh is not None:
                materials = {
                    m.get("symbol", ""): m.get("target", "")
                    for m in instance.iter("instance_material")
                }
                yield from self._mesh(mesh, place, materials)
        for child in node.findall("node"):
            yield from self._node(child, place)
        for instance in node.findall("instance_node"):
            yield from self._node(self._find(instance.get("url", "")), place)

    def _find(self, url: str) -> ET.Element:
        element = self.byid.get(url.lstrip("#"))
        if element is None:
            raise ValueError(f"no element has the id '{url}'")
        return element

    def _mesh(
        self, mesh: ET.Element, place: np.ndarray, materials: dict[str, str]
    ) -> Iterator[Part]:
        for kind in ("triangles", "polylist", "polygons"):
            for element in mesh.findall(kind):
                source = _input(element, "VERTEX").get("source", "")
                source = _input(self._find(source), "POSITION").get("source", "")
                array = self._find(source).find("float_array")
                points = _numbers(array, float).reshape(-1, 3)
                faces = _faces(element)
                if len(faces) == 0:
                    continue
                used, index = np.unique(faces, return_inverse=True)
                # Vertices at equal positions are merged, so that shading is smooth across faces.
                corners, same = np.unique(points[used], axis=0, return_inverse=True)
                placed = corners @ place[:3, :3].T + place[:3, 3]
                faces = same.ravel()[index.ravel()].reshape(-1, 3)
                if np.linalg.det(place[:3, :3]) < 0:
                    faces = faces[:, ::-1]
                symbol = element.get("material", "")
                yield Part(placed, faces, self._colour(materials.get(symbol, symbol)))

    def _colour(self, url: str) -> tuple[float, float, float, float] | None:
        material = self.byid.get(url.lstrip("#"))
        effect = material.find("instance_effect") if material is not None else None
        if effect is None:
            return None
        colour = self._find(effect.get("url", "")).find(".//diffuse/color")
        if colour is None:
            return None
        values = _numbers(colour, float)
        return (float(values[0]), float(values[1]), float(values[2]), 1.0)


def _numbers(element: ET.Element | None, kind: type) -> np.ndarray:
    text = element.text if element is not None else None
    numbers: np.ndarray = np.array((text or "").split(), dtype=kind)
    return numbers


def _input(element: ET.Element, semantic: str) -> ET.Element:
    for entry in element.findall("input"):
        if entry.get("semantic") == semantic:
            return entry
    raise ValueError(f"<{element.tag}> has no input {semantic}")


def _faces(element: ET.Element) -> np.ndarray:
    """Return position indices of triangles, shape (m, 3); polygons are split into fans."""
    width = 1 + max(int(e.get("offset", 0)) for e in element.findall("input"))
    offset = int(_input(element, "VERTEX").get("offset", 0))
    lists = [_numbers(p, int).reshape(-1, width)[:, offset] for p in element.findall("p")]
    if element.tag == "triangles":
        corners: np.ndarray = np.concatenate([*lists, np.empty(0, int)])
        return corners.reshape(-1, 3)
    if element.tag == "polygons":
        sizes = np.array([len(entry) for entry in lists], dtype=int)
    else:
        sizes = _numbers(element.find("vcount"), int)
    flat = np.concatenate([*lists, np.empty(0, int)])
    start = np.cumsum(sizes) - sizes
    fans = []
    for size in np.unique(sizes[sizes >= 3]):
        first = start[sizes == size]
        for k in range(1, size - 1):
            fans.append(np.stack([flat[first], flat[first + k], flat[first + k + 1]], axis=1))
    return np.concatenate(fans) if fans else np.empty((0, 3), int)


def _transform(node: ET.Element) -> np.ndarray:
    total = np.eye(4)
    for element in node:
        step = np.eye(4)
        if element.tag not in ("matrix", "translate", "scale", "rotate"):
            continue
        values = _numbers(element, float)
        if element.tag == "matrix":
            step = values.reshape(4, 4)
        elif element.tag == "translate":
            step[:3, 3] = values
        elif element.tag == "scale":
            step[:3, :3] = np.diag(values)
        else:
            step[:3, :3] = _rotation(values[:3], np.deg2rad(values[3]))
        total = total @ step
    return total


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis / np.linalg.norm(axis)
    cross: np.ndarray = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn: np.ndarray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return turn
