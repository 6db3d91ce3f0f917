"""Reference of the swing foot: re-targetable quintics, ended by contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from wbc.geometry.planar import Placement, wrap_angle
from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients, step_quintic

# Shares of the swing's duration.
_FREEZE = 0.2  # at its end: the target no longer moves
_LIFT = 0.05  # at its start: straight up, so that a toe clears the edge it stands at
_APEX = 0.5  # when the apex is reached
_LATE_ACCELERATION = 6.0  # m/s², downwards, of a foot that is late
_LATE_SPEED = 0.4  # m/s, at the most


@dataclass(slots=True)
class _Axis:
    """A scalar or planar coordinate with its first two derivatives."""

    x: complex
    v: complex = 0.0
    a: complex = 0.0

    def advance(self, target: complex, speed: complex, remaining: float, dt: float) -> None:
        """One step of dt on the quintic that is at `target`, with `speed`, after `remaining` s."""
        self.x, self.v, self.a = step_quintic(self.x, self.v, self.a, target, speed, remaining, dt)

    def way(self, target: complex, speed: complex, remaining: float) -> Callable[[float], complex]:
        """The position over time, from now (0) to `remaining` s, on that quintic."""
        start = self.x
        if remaining <= 0.0:
            return lambda t: start
        T = remaining
        c = quintic_coefficients(start, self.v * T, self.a * T * T, target, speed * T)

        def position(t: float) -> complex:
            return complex(evaluate_quintic(c, min(max(t / T, 0.0), 1.0))[0])

        return position


class SwingFoot:
    """Reference of the swing sole's centre from lift-off to touchdown.

    Horizontal position and heading are quintics whose end may be moved; they begin when the
    foot has lifted. The height rises to an apex and comes down at a
    small speed; after the planned time the descent quickens until something is touched,
    because the DCM runs away from a foot that is late.

    Args:
        start: where the sole leaves the ground.
        target: where it should land.
        duration: of the whole swing, s.
        height: of the apex above the higher end, m.
        touchdown_speed: downward, m/s.
    """

    def __init__(
        self,
        start: Placement,
        target: Placement,
        duration: float,
        height: float,
        touchdown_speed: float,
    ) -> None:
        self.start = start
        self.target = target
        self.duration = duration
        self.time = 0.0
        self._touchdown_speed = touchdown_speed
        self._higher = max(start.height, target.height)
        self.set_apex(height)
        self._plane = _Axis(start.point)
        self._yaw = _Axis(start.yaw)
        self._height = _Axis(start.height)

    def set_apex(self, height: float) -> None:
        """Have the apex so far above the higher end, m; what is over already stays."""
        self._apex = self._higher + height

    def advance(self, dt: float, target: Placement) -> None:
        """Move on by dt towards `target`, which counts until the last part of the swing.

        Then the target stays: a quintic that is bent with little time left answers a
        millimetre of measurement noise with metres per second squared.
        """
        remaining = self.duration - self.time
        if not self.target_frozen:
            self.target = target
        self.time += dt
        target = self.target
        yaw = float(self._yaw.x.real)
        goal = yaw + wrap_angle(target.yaw - yaw)
        if self.time > _LIFT * self.duration:
            self._plane.advance(target.point, 0.0, remaining, dt)
            self._yaw.advance(goal, 0.0, remaining, dt)
        fall = (1.0 - _APEX) * self.duration
        if remaining > fall:
            self._height.advance(self._apex, 0.0, remaining - fall, dt)
        elif remaining > 0.0:
            self._height.advance(target.height, -self._touchdown_speed, remaining, dt)
        else:
            fast = self._height.v.real <= -_LATE_SPEED
            self._height.a = 0.0 if fast else -_LATE_ACCELERATION
            self._height.v += self._height.a * dt
            self._height.x += self._height.v * dt

    @property
    def target_frozen(self) -> bool:
        """Whether the landing place no longer moves."""
        return self.duration - self.time <= _FREEZE * self.duration

    @property
    def position(self) -> tuple[float, float, float]:
        """World position of the sole's centre, m."""
        return (self._plane.x.real, self._plane.x.imag, self._height.x.real)

    @property
    def velocity(self) -> tuple[float, float, float]:
        """m/s."""
        return (self._plane.v.real, self._plane.v.imag, self._height.v.real)

    @property
    def acceleration(self) -> tuple[float, float, float]:
        """m/s²."""
        return (self._plane.a.real, self._plane.a.imag, self._height.a.real)

    @property
    def yaw(self) -> float:
        """Heading, rad."""
        return self._yaw.x.real

    @property
    def yaw_rate(self) -> float:
        """rad/s."""
        return self._yaw.v.real

    @property
    def yaw_acceleration(self) -> float:
        """rad/s²."""
        return self._yaw.a.real

    def path(self, points: int = 12) -> list[tuple[float, float, float]]:
        """The way still to go, for display: positions from now to touchdown."""
        duration, target = self.duration, self.target
        left = max(duration - self.time, 0.0)
        wait = min(max(_LIFT * duration - self.time, 0.0), left)  # straight up for so long
        rise = max(left - (1.0 - _APEX) * duration, 0.0)
        apex = _Axis(self._apex) if rise > 0.0 else self._height
        plane = self._plane.way(target.point, 0.0, left - wait)
        up = self._height.way(self._apex, 0.0, rise)
        down = apex.way(target.height, -self._touchdown_speed, left - rise)
        way = []
        for k in range(points + 1 if left > 0.0 else 1):
            t = left * k / points
            p = plane(t - wait)
            z = up(t) if t < rise else down(t - rise)
            way.append((p.real, p.imag, z.real))
        return way
