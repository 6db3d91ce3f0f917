"""The surface of a foot as points, to which a sole is fitted.

Only the foot's own geometry is read, so that loading does not wait for the meshes of a whole
robot.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from wbc.robot.geometry import shape_defect, shape_of
from wbc.robot.packages import mesh_unit, resolve, up_axis_rotation
from wbc.robot.urdf import Urdf

CYLINDER_POINTS = 24


@dataclass(frozen=True, slots=True)
class FootSurface:
    """Spheres whose convex hull is the foot, in the frame of the joint that moves it.

    Attributes:
        points: (n, 3) centres, m.
        radii: (n,) radii, m; zero for the vertices of meshes and boxes.
        kind: `collision` or `visual`.
        missing: addresses of meshes that could not be read.
    """

    points: np.ndarray
    radii: np.ndarray
    kind: str
    missing: tuple[str, ...] = ()

    def lowest(self, up: np.ndarray) -> np.ndarray:
        """Return (n, 3) the lowest point of each sphere along the unit vector `up` (3,)."""
        return np.asarray(self.points - self.radii[:, None] * up)


def foot_surface(
    urdf: Urdf,
    model: pin.Model,
    joint_id: int,
    folders: tuple[Path, ...],
    respect_up_axis: bool = False,
    kinds: tuple[str, ...] = ("collision", "visual"),
) -> FootSurface:
    """Return the shapes of all links that move with a joint, of the first kind that there is."""
    missing: list[str] = []
    for kind in kinds:
        parts: list[tuple[np.ndarray, float]] = []
        for name, link in urdf.links.items():
            if not model.existBodyName(name):
                continue
            frame = model.frames[model.getFrameId(name, pin.BODY)]
            if frame.parentJoint != joint_id:
                continue
            for element in link.findall(kind):
                if shape_defect(urdf, element) is not None:
                    continue
                placement = frame.placement * _origin(element, urdf)
                points_and_radius = _points(element, urdf, folders, missing, respect_up_axis)
                if points_and_radius is not None:
                    points, radius = points_and_radius
                    parts.append((points @ placement.rotation.T + placement.translation, radius))
        if parts:
            return FootSurface(
                np.vstack([points for points, _ in parts]),
                np.concatenate([np.full(len(points), radius) for points, radius in parts]),
                kind,
                tuple(missing),
            )
    return FootSurface(np.zeros((0, 3)), np.zeros(0), "none", tuple(missing))


def _origin(element: ET.Element, urdf: Urdf) -> pin.SE3:
    origin = element.find("origin")
    xyz = urdf.numbers(origin, "xyz", (0.0, 0.0, 0.0))
    rpy = urdf.numbers(origin, "rpy", (0.0, 0.0, 0.0))
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


def _points(
    element: ET.Element,
    urdf: Urdf,
    folders: tuple[Path, ...],
    missing: list[str],
    respect_up_axis: bool,
) -> tuple[np.ndarray, float] | None:
    """Return points (n, 3) in the shape's frame and their common radius, m."""
    shape = shape_of(element)
    if shape is None:
        return None
    if shape.tag == "box":
        half = 0.5 * np.array(urdf.numbers(shape, "size", (0.0, 0.0, 0.0)))
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return signs * half, 0.0
    if shape.tag == "sphere":
        return np.zeros((1, 3)), urdf.numbers(shape, "radius", (0.0,))[0]
    if shape.tag in ("cylinder", "capsule"):
        radius = urdf.numbers(shape, "radius", (0.0,))[0]
        half_length = 0.5 * urdf.numbers(shape, "length", (0.0,))[0]
        ends = np.array([[0.0, 0.0, -half_length], [0.0, 0.0, half_length]])
        if shape.tag == "capsule":
            return ends, radius
        angle = np.arange(CYLINDER_POINTS) * (2.0 * np.pi / CYLINDER_POINTS)
        rim = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(CYLINDER_POINTS)])
        return np.vstack([rim + end for end in ends]), 0.0
    if shape.tag == "mesh":
        address = shape.get("filename", "")
        path = resolve(address, urdf.path, folders)
        vertices = (
            _mesh(path, np.array(urdf.numbers(shape, "scale", (1.0, 1.0, 1.0)))) if path else None
        )
        if path is None or vertices is None:
            missing.append(address)
            return None
        return (vertices @ up_axis_rotation(path).T if respect_up_axis else vertices), 0.0
    return None


def _mesh(path: Path, scale: np.ndarray) -> np.ndarray | None:
    """Return the (n, 3) vertices of a mesh file, m; None if it cannot be read."""
    import coal

    try:
        mesh = coal.MeshLoader().load(str(path), scale)
        vertices = np.array(mesh.vertices(), dtype=float).reshape(-1, 3)
    except Exception:
        return None
    vertices *= mesh_unit(path)
    return vertices if len(vertices) and np.isfinite(vertices).all() else None
