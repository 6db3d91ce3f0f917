"""The rectangle on which a foot rests, fitted to the foot's own shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.geometry.polygon import convex_hull, polygon_area
from wbc.geometry.rectangle import inscribed_rectangle
from wbc.robot.foot_surface import FootSurface

# Foot points this far above the lowest one still count as sole, m (rounded edges).
SOLE_THICKNESS = 0.004
# How far a foot axis may be from vertical and still be taken for the sole's normal.
SNAP_ANGLE = np.deg2rad(30.0)
# Toe-out up to this is a habit of the posture, not of the foot's own axes.
HEADING_SNAP = np.deg2rad(20.0)
# Two candidate planes whose contact areas differ by less than this are equally good.
AREA_TIE = 0.02
# A foot whose contact area is a smaller share of its outline than this does not lie flat.
FLAT_SHARE = 0.3
# A wheel's centre is off its axle by less than this share of its radius.
ROUND = 0.1
# Points this near to the ground touch it while a foot topples, m.
TOUCH = 1e-4
# A toppling foot of many small facets takes that many turns at most.
TOPPLING_STEPS = 200
# Thicknesses of the layers in which planes are compared, m.
LAYERS = (2e-3, 1e-3, 5e-4, 2e-4)


@dataclass(frozen=True, slots=True)
class SoleFit:
    """A rectangle fitted to a foot.

    Attributes:
        placement: T_joint_sole.
        half_length: along x, m.
        half_width: along y, m.
        source: origin of the normal, for messages.
        flat: whether the foot has a face there, rather than an edge or something round.
    """

    placement: pin.SE3
    half_length: float
    half_width: float
    source: str
    flat: bool


def fit_sole(
    surface: FootSurface, up: np.ndarray, forward: np.ndarray, axes: np.ndarray
) -> SoleFit:
    """Return the rectangle on which a foot rests.

    The normal is the candidate (each foot axis within 30° of up, up itself,
    the planes through their lowest points) that lets the foot rest on the largest
    area: exporters tilt feet and swap their axes, but a sole is where it is flat.

    Args:
        surface: the foot, in joint coordinates.
        up: (3,) unit vector roughly against gravity when the foot stands, in joint coordinates.
        forward: (3,) the robot's forward direction, in joint coordinates.
        axes: (3, n) candidate axes as columns, unit, in joint coordinates.
    """
    best: tuple[float, str, np.ndarray] | None = None
    for source, normal in _normals(surface, up, axes):
        area = _area(surface, normal, forward)
        if best is None or area > best[0] * (1.0 + AREA_TIE):
            best = (area, source, normal)
    assert best is not None
    _, source, normal = best
    return _rectangle(surface, normal, _heading(forward, normal, axes), source)


def fit_point(surface: FootSurface, up: np.ndarray, forward: np.ndarray) -> SoleFit:
    """Return where a foot that turns with its shank touches the ground, with `up` as its normal.

    Args:
        surface: the foot, in joint coordinates.
        up: (3,) unit vector against gravity in the posture in which the foot stands.
        forward: (3,) the robot's forward direction, in joint coordinates.
    """
    ahead = forward - (forward @ up) * up
    return _rectangle(surface, up, ahead / np.linalg.norm(ahead), "nominal posture")


def _rectangle(
    surface: FootSurface, normal: np.ndarray, x_axis: np.ndarray, source: str
) -> SoleFit:
    """Return the rectangle on which a foot rests with a normal and a heading, (3,) unit vectors."""
    y_axis = np.cross(normal, x_axis)
    points = surface.lowest(normal)
    height = points @ normal
    plan = np.column_stack([points @ x_axis, points @ y_axis])
    x0, x1, y0, y1 = inscribed_rectangle(_hull(plan[height < height.min() + SOLE_THICKNESS]))
    rotation = np.column_stack([x_axis, y_axis, normal])
    center = rotation @ np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1), height.min()])
    placement = pin.SE3(rotation, center)
    flat = _area(surface, normal, x_axis) >= FLAT_SHARE * polygon_area(_hull(plan))
    return SoleFit(placement, 0.5 * (x1 - x0), 0.5 * (y1 - y0), source, flat)


def resting_normal(surface: FootSurface, up: np.ndarray) -> np.ndarray:
    """Return the (3,) normal of the face onto which the foot topples from a tilted start.

    The foot, a solid put down on a plane with `up` (3,) upwards, turns about the point or edge
    that touches in the direction that lowers its centroid, until it rests on a face.
    """
    points, normal = surface.points, np.asarray(up)
    centroid = points.mean(axis=0)
    for _ in range(TOPPLING_STEPS):
        height = points @ normal - (points @ normal).min()
        touching = points[height < TOUCH]
        pivot = touching.mean(axis=0)
        toppling = (centroid - pivot) - ((centroid - pivot) @ normal) * normal
        edge = touching - pivot
        _, spread, directions = np.linalg.svd(edge, full_matrices=False)
        if len(touching) > 2 and spread[1] > TOUCH:
            break
        if len(touching) > 1:  # only about the edge that touches
            toppling -= (toppling @ directions[0]) * directions[0]
        if np.linalg.norm(toppling) < TOUCH:
            break
        toppling /= np.linalg.norm(toppling)
        ahead = (points - pivot) @ toppling
        coming = (ahead > TOUCH) & (height >= TOUCH)
        if not coming.any():
            break
        angle = float(np.arctan2(height, ahead)[coming].min())
        normal = np.cos(angle) * normal - np.sin(angle) * toppling
    return np.asarray(normal / np.linalg.norm(normal))


def is_round(surface: FootSurface, axis: np.ndarray) -> bool:
    """Whether a foot is as large on one side of its joint's axis (3,) as on the other.

    Args:
        surface: the foot, in joint coordinates.
        axis: (3,) unit vector through the origin of the joint.
    """
    across = surface.points - np.outer(surface.points @ axis, axis)
    reach = np.linalg.norm(across, axis=1) + surface.radii
    middle = 0.5 * (across.max(axis=0) + across.min(axis=0))
    return bool(np.linalg.norm(middle) < ROUND * reach.max())


def _normals(
    surface: FootSurface, up: np.ndarray, axes: np.ndarray
) -> list[tuple[str, np.ndarray]]:
    near = [axis for axis in np.hstack([axes, -axes]).T if axis @ up > np.cos(SNAP_ANGLE)]
    found = [("foot axis", axis) for axis in near] + [("upright position", up)]
    for normal in (*near, up):
        plane = _plane(surface, normal)
        if plane is not None:
            found.append(("plane of the lowest points", plane))
    return found


def _plane(surface: FootSurface, up: np.ndarray) -> np.ndarray | None:
    """(3,) normal of the plane through the points that are lowest along `up`, if they span one."""
    points = surface.lowest(up)
    low = points[points @ up < (points @ up).min() + SOLE_THICKNESS]
    if len(low) < 3:
        return None
    _, spread, directions = np.linalg.svd(low - low.mean(axis=0), full_matrices=False)
    normal = directions[2] * np.sign(directions[2] @ up)
    # A line of points has no plane, and a steep one is an edge.
    return normal if spread[1] > 1e-3 and normal @ up > np.cos(SNAP_ANGLE) else None


def _area(surface: FootSurface, normal: np.ndarray, forward: np.ndarray) -> float:
    """Area on which the foot rests when `normal` is up, m²: mean over ever thinner layers."""
    points = surface.lowest(normal)
    height = points @ normal - (points @ normal).min()
    x_axis = forward - (forward @ normal) * normal
    x_axis /= np.linalg.norm(x_axis)
    plan = np.column_stack([points @ x_axis, points @ np.cross(normal, x_axis)])
    return float(np.mean([polygon_area(_hull(plan[height < layer])) for layer in LAYERS]))


def _hull(points: np.ndarray) -> list[complex]:
    """Return the convex hull of points (n, 2), m; mesh vertices closer than 1 nm are one."""
    return convex_hull({complex(x, y) for x, y in np.round(points, 9).tolist()})


def _heading(forward: np.ndarray, normal: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """(3,) unit x axis of the sole: the foot axis nearest to forward, or forward itself."""

    def flat(axis: np.ndarray) -> np.ndarray:
        level = axis - (axis @ normal) * normal
        return np.asarray(level / np.linalg.norm(level))

    ahead = flat(forward)
    both = np.hstack([axes, -axes]).T
    level = [flat(axis) for axis in both if abs(axis @ normal) < 0.5]
    near = max(level, key=lambda axis: float(axis @ ahead), default=ahead)
    return near if near @ ahead > np.cos(HEADING_SNAP) else ahead
