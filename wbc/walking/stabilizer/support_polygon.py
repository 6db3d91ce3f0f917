"""Support polygon: the ground that the standing soles span, and where the ZMP may be on it."""

from __future__ import annotations

from wbc.gait import SWING, Feet, GaitState
from wbc.geometry.polygon import clamp_to_polygon, convex_hull, is_near_segment, sole_corners
from wbc.robot import Robot, Sole


class SupportPolygon:
    """Convex hull of the soles that stand, and what hands in contact add to it.

    Args:
        robot: the robot with these soles.

    Attributes:
        extension: displacements of the pivot that forces on the hands allow, m; see
            `HandContacts`.
    """

    def __init__(self, robot: Robot) -> None:
        self._soles: dict[str, Sole] = {s.side: s for s in robot.soles}
        self.extension: tuple[complex, ...] = ()
        self._radius = min(min(s.half_length, s.half_width) for s in robot.soles)

    def corners(self, state: GaitState) -> list[complex]:
        """Corners of the support polygon, counter-clockwise, ground points, m."""
        if state.phase is SWING:
            return self._extended(self._sole_corners(state.feet, state.support))
        return self.hull(state.feet)

    def hull(self, feet: Feet) -> list[complex]:
        """Corners of the convex hull of both soles, counter-clockwise, ground points, m."""
        soles = self._sole_corners(feet, "left") + self._sole_corners(feet, "right")
        return self._extended(convex_hull(soles))

    def _extended(self, corners: list[complex]) -> list[complex]:
        """Add what the hands allow to the corners of a polygon."""
        if not self.extension:
            return corners
        return convex_hull([corner + added for corner in corners for added in self.extension])

    def _sole_corners(self, feet: Feet, side: str) -> list[complex]:
        sole = self._soles[side]
        return sole_corners(feet.of(side), sole.half_length, sole.half_width)

    def clamp(self, zmp: complex, state: GaitState, margin: float) -> complex:
        """The ground point nearest to a ZMP that is off the polygon by `margin` (m) at most."""
        # The polygon holds everything that is closer to the line between the soles' centres
        # than their sides are: most ZMPs need no polygon.
        center, near = state.stance.point, self._radius + margin
        if state.phase is SWING:
            inside = abs(zmp - center) <= near
        else:
            inside = is_near_segment(zmp, center, state.other_foot.point, near)
        if inside:
            return zmp
        return clamp_to_polygon(zmp, self.corners(state), margin)

    def zmp_range(self, side: str, share: float) -> tuple[float, float]:
        """Return the largest distances of the ZMP from a sole's centre, along and across it, m.

        Args:
            side: side of the sole.
            share: share of the sole that is used.
        """
        sole = self._soles[side]
        return share * sole.half_length, share * sole.half_width
