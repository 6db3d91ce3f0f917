"""Look: the head, or the trunk of a robot without a head, follows a point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wbc.errors import MotionError
from wbc.kinematics import Kinematics
from wbc.motions.engine import (
    Motion,
    MotionContext,
    Script,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

_AHEAD = 1.5  # m: default distance of the point, at the height of the eyes
_ALONG = 0.7  # cosine from which on a joint's axis counts as pitch or yaw
_RANGE = 0.85  # share of a joint's range that may be used
_TRUNK_PITCH = 0.35  # rad that the trunk contributes at most
_HIPS_YAW = 0.15  # rad that the hips add to the waist's yaw
_SETTLING = 1.5  # s at the start that do not count in the gaze error


@dataclass(frozen=True)
class Look(Motion):
    """Follow a point with the gaze; the point moves on an ellipse that faces the robot.

    The neck turns as far as its joints allow, the trunk does the rest; a robot without a head
    looks with its chest.
    """

    name: ClassVar[str] = "look"
    summary: ClassVar[str] = "follow a point with head or trunk"

    point: tuple[float, ...] | None = parameter(
        None, "centre of the ellipse, standing frame, m (default: ahead)", names=("X", "Y", "Z")
    )
    radius: float = parameter(0.4, "half-axis of the ellipse sideways, m; half of it vertically")
    frequency: float = parameter(0.2, "frequency of the ellipse, Hz")
    seconds: float = parameter(6.0, "duration of the motion, s")

    @property
    def while_walking(self) -> bool:
        """See `Motion.while_walking`."""
        return True

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "frequency", "seconds")
        if not 0.0 <= self.radius < math.inf:
            raise MotionError(f"look: radius = {self.radius} m must not be negative")
        gaze = self._gaze(robot)
        for k in range(24):
            yaw, pitch = gaze.angles(self._point(gaze, k / 24.0 / self.frequency))
            for what, angle, limit in (
                ("to the side", yaw, gaze.max_yaw),
                ("up", -pitch, gaze.max_up),
                ("down", pitch, gaze.max_down),
            ):
                angle = abs(angle) if what == "to the side" else angle
                if angle > limit:
                    raise MotionError(
                        f"look: {robot.name} would have to look {math.degrees(angle):.0f}° {what}, "
                        f"which is {math.degrees(angle - limit):.0f}° more than it can"
                    )

    @once_per_robot
    def _gaze(self, robot: Robot) -> GazeAllocation:
        return GazeAllocation(robot)

    def _point(self, gaze: GazeAllocation, time: float) -> np.ndarray:
        """Return the position of the point at a time, standing frame, (3,) m."""
        middle = (
            gaze.eye + np.array([_AHEAD, 0.0, 0.0]) if self.point is None else np.array(self.point)
        )
        angle = 2.0 * math.pi * self.frequency * time
        way = np.array([0.0, math.sin(angle), -0.5 * math.cos(angle)])
        return np.asarray(middle + self.radius * way)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        gaze = self._gaze(context.robot)
        home = context.posture.home

        def angles(time: float) -> tuple[float, float]:
            return gaze.angles(self._point(gaze, time))

        context.posture.follow(lambda t: home + gaze.joints(*angles(t)), blend=1.0)
        context.torso.follow(lambda t: gaze.trunk(*angles(t)), blend=1.0)
        context.pelvis.follow(
            lambda t: context.upper_body.hips_share(gaze.trunk(*angles(t))), blend=1.0
        )
        end = context.time + self.seconds
        squares, ticks, start = 0.0, 0, context.time
        while context.time < end:
            yield
            if context.time - start > _SETTLING:
                error = gaze.error(context, self._point(gaze, context.time - start))
                squares, ticks = squares + error * error, ticks + 1
        context.note(f"gaze off by {math.degrees(math.sqrt(squares / max(ticks, 1))):.1f}° rms")
        yield from context.settle_upper_body(1.0)


class GazeAllocation:
    """Distributes the angles of a gaze over the joints of the neck and the trunk.

    A joint takes `limit · tanh(angle / limit)`, smooth up to its limit; the trunk takes the rest.

    Args:
        robot: the robot.

    Attributes:
        eye: (3,) position of the eyes, standing frame, m.
        max_yaw: greatest angle to either side, rad.
        max_up: greatest angle upwards, rad.
        max_down: greatest angle downwards, rad.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        upper_body = UpperBody.of(robot)
        head = upper_body.head
        self._frame = robot.torso if head is None else head.frame
        here = Kinematics(robot, robot.standing()).motion(self._frame)
        self._forward = here.rotation.T @ np.array([1.0, 0.0, 0.0])
        self.eye = np.array(here.position)
        self._yaw = self._pitch = (-1, 0.0, 0.0, 0.0)  # joint, its sign, least and largest angle
        for joint in head.joints if head is not None else ():
            axis = here.jacobian[3:, 6 + joint]
            sign = float(np.sign(axis[int(np.argmax(np.abs(axis)))]))
            now = robot.q_nominal[7 + joint]
            ends = sorted(sign * _RANGE * (x[joint] - now) for x in (robot.q_min, robot.q_max))
            found = (joint, sign, ends[0], ends[1])
            if abs(axis[2]) > _ALONG and self._yaw[0] < 0:
                self._yaw = found
            elif abs(axis[1]) > _ALONG and self._pitch[0] < 0:
                self._pitch = found
        waist = _RANGE * upper_body.waist_range[2]
        trunk_yaw = min(abs(waist[0]), waist[1]) + _HIPS_YAW
        self.max_yaw = min(abs(self._yaw[2]), self._yaw[3]) + trunk_yaw
        self.max_down = self._pitch[3] + _TRUNK_PITCH
        self.max_up = -self._pitch[2] + 0.5 * _TRUNK_PITCH

    def angles(self, point: np.ndarray) -> tuple[float, float]:
        """Return yaw to the left and pitch downwards from the eyes to a point, rad."""
        x, y, z = point - self.eye
        return math.atan2(y, x), -math.atan2(z, math.hypot(x, y))

    def joints(self, yaw: float, pitch: float) -> np.ndarray:
        """Return the offsets of the neck's joints from their nominal positions, (na,) rad."""
        turn = np.zeros(self._robot.na)
        for angle, (joint, sign, low, high) in ((yaw, self._yaw), (pitch, self._pitch)):
            if joint >= 0:
                turn[joint] = sign * _soft(angle, low, high)
        return turn

    def trunk(self, yaw: float, pitch: float) -> np.ndarray:
        """Return the rotation vector of the upper trunk for what the neck leaves, (3,) rad."""
        left = [
            angle - _soft(angle, low, high)
            for angle, (_, _, low, high) in ((yaw, self._yaw), (pitch, self._pitch))
        ]
        return np.array([0.0, left[1], left[0]])

    def error(self, context: MotionContext, point: np.ndarray) -> float:
        """Return the estimated angle between the gaze and the direction of a point, rad."""
        at = context.walker.kinematics.frame(self._frame)
        frame = context.walker.standing_frame
        way = frame.act(point) - at.translation
        gaze = at.rotation @ self._forward
        return math.atan2(float(np.linalg.norm(np.cross(gaze, way))), float(gaze @ way))


def _soft(angle: float, low: float, high: float) -> float:
    limit = high if angle >= 0.0 else -low
    return limit * math.tanh(angle / limit) if limit > 1e-6 else 0.0
