"""Reference of the swing foot: re-targetable quintics, ended by contact."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from wbc.gait.kernels.swing import APEX, LIFT, advance_swing, tilt
from wbc.geometry.planar import Placement
from wbc.geometry.quintic import PEAK_ACCELERATION, evaluate_quintic, quintic_coefficients
from wbc.tasks import TaskReference

_UPRIGHT = 0.25  # share of the duration in which a foot goes straight up a high stair, or down
_FREEZE = 0.2  # share of the duration, at its end, in which the target no longer moves
_LIFTED = 0.03  # m over its landing place from which on a foot that was knocked needs no apex


class SwingFoot:
    """Reference of the swing sole's centre from lift-off to touchdown.

    Horizontal position and heading are quintics whose end may be moved; they begin when the
    foot has lifted. The height rises to an apex and comes down at a
    small speed; after the planned time the descent quickens until something is touched,
    because the DCM runs away from a foot that is late.

    Args:
        start: placement at which the sole leaves the ground.
        target: placement at which it is to land.
        duration: duration of the whole swing, s.
        height: height of the apex above the higher end, m.
        touchdown_speed: downward, m/s.
        slope: slope of the sole when it leaves the ground: rise per metre along world x, and along
            y as the imaginary part.
        lift: share of the duration in which it goes straight up at its start; see `lift_share`.

    Attributes:
        start: placement at which the sole left the ground.
        target: placement at which it lands.
        duration: duration of the whole swing, s.
        time: since lift-off, s.
        motion: pose, velocity and acceleration of the sole's centre now, world axes.
        yaw: heading now, rad.
        knocked: whether a blow has thrown it off its way, see `follow`.
    """

    def __init__(
        self,
        start: Placement,
        target: Placement,
        duration: float,
        height: float,
        touchdown_speed: float,
        slope: complex = 0j,
        lift: float = LIFT,
    ) -> None:
        self.start = start
        self.target = target
        self.duration = duration
        self.time = 0.0
        self.knocked = False
        self._descends = False  # goes down without an apex
        self._aimed = 0.0  # s, when it was last aimed anew
        self.motion = TaskReference(np.eye(4), np.zeros(6), np.zeros(6))
        self.motion.position[:] = start.point.real, start.point.imag, start.height
        self.yaw = start.yaw
        self._touchdown_speed = touchdown_speed
        self._start_slope = slope
        # Up a stair the toe first clears its edge, down one the heel that of the stair it leaves.
        rise = target.height - start.height
        steep = min(abs(rise) / (abs(rise) + height), 1.0)
        self._lift = lift + (_UPRIGHT * steep if rise > 0.0 else 0.0)
        self._arrival = 1.0 - (_UPRIGHT * steep if rise < 0.0 else 0.0)
        tilt(self.motion.pose, start.yaw, slope.real, slope.imag)
        self._higher = max(start.height, target.height)
        self.set_apex(height)

    def set_apex(self, height: float) -> None:
        """Have the apex so far above the higher end, m; what is over already stays."""
        self._apex = self._higher + height

    def advance(self, dt: float, target: Placement, slope: complex = 0j) -> None:
        """Move on by dt towards `target`, which counts until the last part of the swing.

        The sole turns until it has the slope of the ground there, see `GaitState.ground_slope`.

        Then the target stays: a quintic that is bent with little time left answers a
        millimetre of measurement noise with metres per second squared.
        """
        if not self.target_frozen:
            self.target = target
        motion, (point, yaw, height) = self.motion, self.target
        if self.knocked and float(motion.position[2]) > height + _LIFTED:
            self._descends = True
        self.yaw = advance_swing(
            motion.pose,
            motion.velocity,
            motion.acceleration,
            self.yaw,
            self.time,
            self.duration,
            dt,
            point.real,
            point.imag,
            height,
            yaw,
            self._apex,
            self._touchdown_speed,
            self._start_slope.real,
            self._start_slope.imag,
            slope.real,
            slope.imag,
            self._lift,
            self._arrival,
            self._fall,
        )
        self.time += dt

    def aim_anew(self) -> None:
        """Let the target move again: it stays in the last part of what is left from now on."""
        self._aimed = self.time

    def follow(self, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> None:
        """Go on from where a blow has thrown the foot: the way to the target begins there.

        Once it is well above its landing place, it goes down from there without an apex.

        Args:
            position: (3,) of the sole's centre, world, m.
            velocity: (3,) m/s.
            acceleration: (3,) with which it goes on, m/s².
        """
        motion = self.motion
        motion.position[:] = position
        motion.velocity[:3] = velocity
        motion.acceleration[:3] = acceleration
        self.knocked, self._lift = True, 0.0
        self.aim_anew()

    def time_to(self, point: complex, acceleration: float) -> float:
        """Time in which the foot gets to a ground point and stops there, s.

        From rest to rest over a distance d, a quintic of duration T accelerates by at most
        `(10/√3) d / T²`. A foot that moves towards the point at a speed v saves about `v T / 2` of
        the way, so that `T² a √3/10 + T v/2 = d`.

        Args:
            point: m.
            acceleration: largest horizontal acceleration a, m/s².
        """
        x, y, _ = self.motion.position.tolist()
        v_x, v_y, *_ = self.motion.velocity.tolist()
        way = point - complex(x, y)
        distance = abs(way)
        if distance == 0.0:
            return 0.0
        half_speed = 0.5 * (complex(v_x, v_y) * way.conjugate()).real / distance
        a = acceleration / PEAK_ACCELERATION
        return (math.sqrt(half_speed * half_speed + 4.0 * a * distance) - half_speed) / (2.0 * a)

    def start_from(self, motion: TaskReference, yaw: float) -> None:
        """Start from a pose and velocity that the foot already has: it is in the air.

        Args:
            motion: of the sole's centre, world axes.
            yaw: its heading, rad.
        """
        self.motion.pose[:] = motion.pose
        self.motion.velocity[:] = motion.velocity
        self.motion.acceleration[:] = motion.acceleration
        self.yaw = yaw

    def start_moving(self, velocity: complex) -> None:
        """Start with the horizontal velocity that the foot has, which is in the air, x + iy, m/s.

        It goes on at once, and need not first lift off.
        """
        self.motion.velocity[0], self.motion.velocity[1] = velocity.real, velocity.imag
        self._lift = 0.0

    def start_at(self, height: float) -> None:
        """Start at a height above the ground, m: a blow brought the foot there.

        Its apex is that of a foot that stood on the ground.
        """
        self.motion.position[2] = height

    @property
    def _fall(self) -> float:
        """Time from the apex to the ground, s."""
        return math.inf if self._descends else (1.0 - APEX) * self.duration

    @property
    def yaw_rate(self) -> float:
        """rad/s."""
        return float(self.motion.velocity[5])

    @property
    def target_frozen(self) -> bool:
        """Whether the landing place no longer moves."""
        whole = self.duration - self._aimed
        return self.duration - self.time <= (_FREEZE + 1.0 - self._arrival) * whole

    def path(self, points: int = 12) -> list[tuple[float, float, float]]:
        """The way still to go, for display: positions from now to touchdown."""
        duration, target = self.duration, self.target
        left = max(duration - self.time, 0.0)
        wait = min(max(self._lift * duration - self.time, 0.0), left)  # straight up for so long
        rise = max(left - self._fall, 0.0)
        motion = self.motion
        (x, y, z), (vx, vy, vz), (ax, ay, az) = (
            part[:3].tolist() for part in (motion.position, motion.velocity, motion.acceleration)
        )
        plane = _quintic(
            complex(x, y),
            complex(vx, vy),
            complex(ax, ay),
            target.point,
            0.0,
            left - wait - (1.0 - self._arrival) * duration,
        )
        up = _quintic(z, vz, az, self._apex, 0.0, rise)
        if rise > 0.0:
            z, vz, az = self._apex, 0.0, 0.0
        down = _quintic(z, vz, az, target.height, -self._touchdown_speed, left - rise)
        way = []
        for k in range(points + 1 if left > 0.0 else 1):
            t = left * k / points
            p = plane(t - wait)
            height = up(t) if t < rise else down(t - rise)
            way.append((p.real, p.imag, height.real))
        return way


def lift_share(fast_share: float) -> float:
    """Return the share of a swing, at its start, in which the foot goes straight up.

    In fast walking it goes forward at once, because its leg's joints have no time to lose.

    Args:
        fast_share: see `GaitState.fast_share`.
    """
    return LIFT * (1.0 - fast_share)


def _quintic(
    x: complex, v: complex, a: complex, target: complex, speed: complex, duration: float
) -> Callable[[float], complex]:
    """The position over time on the quintic that is at `target`, with `speed`, after `duration`."""
    if duration <= 0.0:
        return lambda t: x
    T = duration
    c = quintic_coefficients(x, v * T, a * T * T, target, speed * T)
    return lambda t: complex(evaluate_quintic(c, min(max(t / T, 0.0), 1.0))[0])
