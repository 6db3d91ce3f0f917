"""Fall detector: whether a fall can still be averted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from wbc.gait import Placement
from wbc.geometry.polygon import clamp_to_polygon, convex_hull, sole_corners
from wbc.robot import Robot

#: Sum of the four measures from which on no run recovered, and for how long, s. On pushes of 0.25
#: to 1.0 N·s/kg (five robots, standing and walking, six phases, two seeds) the largest sum from
#: which a robot recovered was 1.42, of 77 that did. Four feet catch more: on pushes of 0.7 to
#: 1.4 N·s/kg from four sides, standing, eight quadrupeds recovered from sums of up to 1.73.
_MAX_INDEX, _MAX_INDEX_ON_FOUR, _INDEX_TIME = 1.45, 1.9, 0.03
#: Time over which the tilt is extrapolated, s; on four feet times √(h / g). On two feet a longer
#: one takes the 5 rad/s that a push gives to the trunk for a fall: with 0.2 s, G1 gave up pushes
#: that it survives.
_LEAD, _LEAD_ON_FOUR = 0.1, 0.66
#: Tilt, rad, and lost share of the height that alone are a fall, for how long, s, and the time over
#: which they are extrapolated, s. A robot may topple or sink with its DCM between its feet: of 302
#: falls of four robots after pushes of 0.5 to 1.4 N·s/kg 17 were without alarm by the sum alone. Of
#: 418 that recovered with no detector, by which the sum gives up 3, these give up one more.
_MAX_TILT, _TILT_TIME, _TILT_LEAD = 0.87, 0.01, 0.03
_MAX_LOST, _LOST_TIME, _LOST_LEAD = 0.36, 0.03, 0.1


class FallDetector:
    """Decides from the estimate alone that a fall is unavoidable.

    A fall counts as unavoidable once one of

        d / h + θ + 0.1 s · θ̇ + (1 − z / h) > 1.45   for 30 ms,
        θ + 0.03 s · θ̇ > 0.87                        for 10 ms,
        (1 − z / h) − 0.1 s · ż / h > 0.36           for 30 ms,

    with d the distance of the DCM from the convex hull of all feet, h the height of the centre
    of mass above the soles in the nominal posture, z its present height above the lowest foot, and
    θ the tilt of the body from the vertical, rad. A rate towards the vertical, a CoM that rises and
    one above its nominal height count as zero. On four feet the first sum is 1.9, with
    0.66 √(h/g) in place of 0.1 s. Its first term is what the next steps would have to make up for
    (T. Koolen et al., *Capturability-based analysis and control of legged locomotion*, IJRR 2012),
    the others tell whether the robot is still fit to make them. A robot that topples or sinks while
    its DCM is between its feet is found by the other two.

    Args:
        robot: the robot.
        dt: control period, s.
    """

    def __init__(self, robot: Robot, dt: float) -> None:
        self._soles = robot.soles
        self._height = robot.com_height
        self._max_index, self._lead = _MAX_INDEX, _LEAD
        if robot.is_quadruped:
            self._max_index = _MAX_INDEX_ON_FOUR
            self._lead = _LEAD_ON_FOUR * math.sqrt(robot.com_height / robot.gravity)
        times = (_INDEX_TIME, _TILT_TIME, _LOST_TIME)
        self._least_ticks = [max(1, round(time / dt)) for time in times]
        self._ticks = [0, 0, 0]

    def reset(self) -> None:
        """Forget the past."""
        self._ticks = [0, 0, 0]

    def update(
        self,
        tilt: tuple[float, float],
        dcm: complex,
        com: tuple[float, float],
        feet: Sequence[Placement],
    ) -> str:
        """Return why a fall is unavoidable; an empty text if it is not.

        Args:
            tilt: angle of the body from the vertical, rad, and its rate, rad/s.
            dcm: divergent component of motion, ground point, m.
            com: world height of the centre of mass, m, and its vertical velocity, m/s.
            feet: all feet, in the order of the robot's soles.
        """
        angle, rate = tilt[0], max(tilt[1], 0.0)
        height = com[0] - min(foot.height for foot in feet)
        lost, sinking = 1.0 - height / self._height, max(-com[1], 0.0) / self._height
        index = angle + self._lead * rate + max(lost, 0.0)
        # The feet themselves are farther from the DCM than the soles: most ticks end here.
        distance = min(abs(dcm - foot.point) for foot in feet)
        if index + distance / self._height > self._max_index:
            distance = abs(dcm - clamp_to_polygon(dcm, self._hull(feet), 0.0))
        measures = (
            index + distance / self._height > self._max_index,
            angle + _TILT_LEAD * rate > _MAX_TILT,
            lost + _LOST_LEAD * sinking > _MAX_LOST,
        )
        unavoidable = False
        for k, beyond in enumerate(measures):
            self._ticks[k] = self._ticks[k] + 1 if beyond else 0
            unavoidable = unavoidable or self._ticks[k] >= self._least_ticks[k]
        if not unavoidable:
            return ""
        distance = abs(dcm - clamp_to_polygon(dcm, self._hull(feet), 0.0))
        return (
            f"the DCM is {distance:.2f} m off the feet, the body is tilted by "
            f"{math.degrees(angle):.0f}° at {math.degrees(tilt[1]):+.0f}°/s, and the centre of "
            f"mass is at {100.0 * (1.0 - lost):.0f} % of its height"
        )

    def _hull(self, feet: Sequence[Placement]) -> list[complex]:
        """Return the corners of the convex hull of all feet, ground points, m."""
        return convex_hull(
            corner
            for sole, foot in zip(self._soles, feet, strict=True)
            for corner in sole_corners(foot, sole.half_length, sole.half_width)
        )
