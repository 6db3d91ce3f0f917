"""Fall detector: whether a fall can still be averted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import attrgetter

from wbc.gait import Placement
from wbc.geometry.polygon import clamp_to_polygon, convex_hull, sole_corners
from wbc.robot import Robot
from wbc.robot.fall import LEAST_HEIGHT, MAX_TILT

#: Sum of the four measures from which hardly a run recovered, and for how long, s. On pushes of
#: 0.25 to 1.0 N·s/kg (five robots, standing and walking, six phases, two seeds) the largest sum
#: from which a robot recovered was 1.42, of 77 that did; on blows of 400 to 500 N on the arms of a
#: walking G1 1.59, of 100. Four feet catch more: on pushes of 0.7 to 1.4 N·s/kg from four sides,
#: standing, eight quadrupeds recovered from sums of up to 1.73.
_MAX_INDEX, _MAX_INDEX_ON_FOUR, _INDEX_TIME = 1.65, 1.9, 0.03
#: Time over which the tilt is extrapolated, s; on four feet times √(h / g). On two feet a longer
#: one takes the 5 rad/s that a push gives to the trunk for a fall: with 0.2 s, G1 gave up pushes
#: that it survives.
_LEAD, _LEAD_ON_FOUR = 0.1, 0.66
#: Time within which the robot falls at its present rate, and for how long, s. A robot may topple
#: or sink with its DCM between its feet: of 302 falls of four robots after pushes of 0.5 to
#: 1.4 N·s/kg 17 came before the sum was too large, none before this. Twice the time gives up runs
#: that recover: Talos rises again from 61 % of the base's height.
_FALL_LEAD, _FALL_TIME = 0.03, 0.01
_HEIGHT = attrgetter("height")


class FallDetector:
    """Decides from the estimate alone that a fall is unavoidable.

    A fall counts as unavoidable once

        d / h + θ + 0.1 s · θ̇ + (1 − z / h) > 1.65        for 30 ms, or
        θ + 0.03 s · θ̇ > 70°  or  b + 0.03 s · ḃ < 0.6    for 10 ms,

    with d the distance of the DCM from the convex hull of all feet, h the height of the centre
    of mass above the soles in the nominal posture, z its present height above the lowest foot,
    θ the tilt of the body from the vertical, rad, and b the height of the base above the lowest
    foot as a share of that in the nominal posture. A rate towards the vertical or upwards and a CoM
    above its nominal height count as zero. On four feet the sum is 1.9, with 0.66 √(h/g) in place
    of 0.1 s. Its first term is what the next steps would have to make up for (T. Koolen et al.,
    *Capturability-based analysis and control of legged locomotion*, IJRR 2012), the others tell
    whether the robot is still fit to make them. The second line is the fall itself, of a robot that
    topples or sinks while its DCM is between its feet.

    Args:
        robot: the robot.
        dt: control period, s.
    """

    def __init__(self, robot: Robot, dt: float) -> None:
        self._soles = robot.soles
        self._height = robot.com_height
        self._least_base_height = LEAST_HEIGHT * float(robot.q_nominal[2])
        self._max_index, self._lead = _MAX_INDEX, _LEAD
        if robot.is_quadruped:
            self._max_index = _MAX_INDEX_ON_FOUR
            self._lead = _LEAD_ON_FOUR * math.sqrt(robot.com_height / robot.gravity)
        self._least_index_ticks = max(1, round(_INDEX_TIME / dt))
        self._least_fall_ticks = max(1, round(_FALL_TIME / dt))
        self._index_ticks = self._fall_ticks = 0

    def reset(self) -> None:
        """Forget the past."""
        self._index_ticks = self._fall_ticks = 0

    def update(
        self,
        tilt: tuple[float, float],
        dcm: complex,
        com_height: float,
        base: tuple[float, float],
        feet: Sequence[Placement],
    ) -> str:
        """Return why a fall is unavoidable; an empty text if it is not.

        Args:
            tilt: angle of the body from the vertical, rad, and its rate, rad/s.
            dcm: divergent component of motion, ground point, m.
            com_height: world height of the centre of mass, m.
            base: world height of the base, m, and its vertical velocity, m/s.
            feet: all feet, in the order of the robot's soles.
        """
        (angle, rate), (base_height, rising), ground = tilt, base, min(map(_HEIGHT, feet))
        turning = rate if rate > 0.0 else 0.0
        lost = 1.0 - (com_height - ground) / self._height
        index = angle + self._lead * turning + (lost if lost > 0.0 else 0.0)
        bound = self._height * (self._max_index - index)
        # A foot's centre is farther from the DCM than the hull of the soles: most ticks end here.
        beyond = abs(dcm - feet[0].point) > bound and self._distance(dcm, feet) > bound
        base_then = base_height - ground + (_FALL_LEAD * rising if rising < 0.0 else 0.0)
        tilt_then = angle + _FALL_LEAD * turning
        falls = tilt_then > MAX_TILT or base_then < self._least_base_height
        self._index_ticks = self._index_ticks + 1 if beyond else 0
        self._fall_ticks = self._fall_ticks + 1 if falls else 0
        if (
            self._index_ticks < self._least_index_ticks
            and self._fall_ticks < self._least_fall_ticks
        ):
            return ""
        return (
            f"the DCM is {self._distance(dcm, feet):.2f} m off the feet, the body is tilted by "
            f"{math.degrees(angle):.0f}° at {math.degrees(rate):+.0f}°/s, and the centre of mass "
            f"is at {100.0 * (1.0 - lost):.0f} % of its height"
        )

    def _distance(self, dcm: complex, feet: Sequence[Placement]) -> float:
        """Return the distance of the DCM from the convex hull of all feet, m."""
        hull = convex_hull(
            corner
            for sole, foot in zip(self._soles, feet, strict=True)
            for corner in sole_corners(foot, sole.half_length, sole.half_width)
        )
        return abs(dcm - clamp_to_polygon(dcm, hull, 0.0))
