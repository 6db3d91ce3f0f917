"""Fall detector: whether a fall can still be averted."""

from __future__ import annotations

import math

from wbc.gait import Feet
from wbc.geometry.polygon import clamp_to_polygon
from wbc.robot import Robot
from wbc.walking.stabilizer import SupportPolygon

#: Sum of the four measures from which on no run recovered, and for how long, s. It was chosen on
#: pushes of 0.3 to 1.2 N·s/kg from eight directions, standing and walking: the largest sum from
#: which a robot recovered was 1.30.
_MAX_INDEX = 1.5
_LEAST_TIME = 0.03
#: Time over which the tilt is extrapolated, s.
_LEAD = 0.2


class FallDetector:
    """Decides from the estimate alone that a fall is unavoidable.

    A fall counts as unavoidable once

        d / h + θ + 0.2 s · θ̇ + (1 − z / h) > 1.5    for 30 ms,

    with d the distance of the DCM from the convex hull of both soles, h the height of the centre
    of mass above the soles in the nominal posture, z its present height above the lower sole, and
    θ the tilt of the body from the vertical, rad. A rate towards the vertical and a CoM above its
    nominal height count as zero. The first term is what the next steps would have to make up for
    (T. Koolen et al., *Capturability-based analysis and control of legged locomotion*, IJRR 2012),
    the others tell whether the robot is still fit to make them.

    Args:
        robot: the robot.
        dt: control period, s.
    """

    def __init__(self, robot: Robot, dt: float) -> None:
        self._support = SupportPolygon(robot)
        self._height = robot.com_height
        self._least_ticks = max(1, round(_LEAST_TIME / dt))
        self._ticks = 0

    def reset(self) -> None:
        """Forget the past."""
        self._ticks = 0

    def update(self, tilt: tuple[float, float], dcm: complex, com_height: float, feet: Feet) -> str:
        """Return why a fall is unavoidable; an empty text if it is not.

        Args:
            tilt: angle of the body from the vertical, rad, and its rate, rad/s.
            dcm: divergent component of motion, ground point, m.
            com_height: world height of the centre of mass, m.
            feet: both soles.
        """
        angle, rate = tilt
        height = com_height - min(feet.left.height, feet.right.height)
        lost = 1.0 - height / self._height
        index = angle
        if rate > 0.0:
            index += _LEAD * rate
        if lost > 0.0:
            index += lost
        # The feet themselves are farther from the DCM than the soles: most ticks end here.
        nearest = min(abs(dcm - feet.left.point), abs(dcm - feet.right.point))
        if index + nearest / self._height <= _MAX_INDEX:
            self._ticks = 0
            return ""
        distance = abs(dcm - clamp_to_polygon(dcm, self._support.hull(feet), 0.0))
        if index + distance / self._height <= _MAX_INDEX:
            self._ticks = 0
            return ""
        self._ticks += 1
        if self._ticks < self._least_ticks:
            return ""
        return (
            f"the DCM is {distance:.2f} m off the soles, the body is tilted by "
            f"{math.degrees(angle):.0f}° at {math.degrees(rate):+.0f}°/s, and the centre of mass "
            f"is at {100.0 * (1.0 - lost):.0f} % of its height"
        )
