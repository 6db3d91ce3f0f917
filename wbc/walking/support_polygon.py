"""The ground that the feet span: its height, and where the ZMP may be."""

from __future__ import annotations

from wbc.gait import Feet, GaitStateMachine, Phase
from wbc.geometry.polygon import clamp_to_polygon, convex_hull, is_near_segment, sole_corners
from wbc.robot import Robot, Sole


class SupportPolygon:
    """The soles that stand, as one area.

    Args:
        robot: whose soles these are.
    """

    def __init__(self, robot: Robot) -> None:
        self._soles: dict[str, Sole] = {s.side: s for s in robot.soles}
        self._radius = min(min(s.half_length, s.half_width) for s in robot.soles)

    def polygon(self, state_machine: GaitStateMachine, feet: Feet) -> list[complex]:
        """Corners of the support polygon, counter-clockwise, ground points."""

        def sole(side: str) -> list[complex]:
            s = self._soles[side]
            return sole_corners(feet.of(side), s.half_length, s.half_width)

        if state_machine.phase is Phase.SWING:
            return sole(state_machine.support)
        return convex_hull(sole("left") + sole("right"))

    def clamped(
        self, zmp: complex, state_machine: GaitStateMachine, feet: Feet, margin: float
    ) -> complex:
        """The ground point nearest to a ZMP that is off the polygon by `margin` (m) at most."""
        a = b = feet.of(state_machine.support).point
        if state_machine.phase is not Phase.SWING:
            b = feet.of(state_machine.swing_side).point
        # The polygon holds all that is closer to the soles' centres than their sides are: it
        # need not be drawn for a ZMP on its way from one to the other.
        if is_near_segment(zmp, a, b, self._radius + margin):
            return zmp
        return clamp_to_polygon(zmp, self.polygon(state_machine, feet), margin)

    def height(self, state_machine: GaitStateMachine, feet: Feet) -> float:
        """Of the ground under the weight, m: it goes from foot to foot with it."""
        support = feet.of(state_machine.support).height
        if state_machine.phase is Phase.SWING:
            return support
        leaving = feet.of(state_machine.swing_side).height
        share = state_machine.progress if state_machine.phase is Phase.TRANSFER else 0.5
        return leaving + (support - leaving) * share

    def reach(self, state_machine: GaitStateMachine, share: float) -> tuple[float, float]:
        """How far from the support sole's centre the ZMP gets along and across it, m."""
        sole = self._soles[state_machine.support]
        return share * sole.half_length, share * sole.half_width
