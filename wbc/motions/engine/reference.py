"""Smooth references: position, velocity and acceleration never jump, whatever is commanded."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from wbc.errors import MotionError
from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients

#: Position over the time since the path was begun, s -> (n,).
Path = Callable[[float], np.ndarray]

#: Difference to a target or path, with its first two derivatives, (n,) each.
_Difference = tuple[np.ndarray, np.ndarray, np.ndarray]

_DT = 0.002  # s, until the first tick gives the control period
_HALF_WIDTH = 2  # ticks, of the central differences along a path
_CORNER = 5.0  # bound of a path's acceleration, in limits of acceleration
SAMPLES = np.linspace(0.0, 1.0, 15)[:, None]
_STRETCH = 1.15  # factor by which a duration grows until it keeps the limits
_SEARCH_END = 60.0  # s
_MAX_DURATION = 30.0  # s


class SmoothReference:
    """A vector that moves to targets and along paths, twice continuously differentiable in time.

    It is a path p plus a decaying difference r to where it was when the path was begun,

        x(t) = p(t) + r(t),   r(0) = x₀ − p(0),   r(T) = ṙ(T) = r̈(T) = 0,

    with r the quintic that also starts with the differences of velocity and acceleration. So
    any command may be replaced by another at any time: value, velocity and acceleration
    continue from where they are.

    Args:
        home: (n,) value at the start.
        speed: limit of |ẋ| in `move_to`, per component, unit/s.
        acceleration: limit of |ẍ| likewise, unit/s².

    Attributes:
        home: (n,) where `reset` puts it.
        value: (n,) present value.
        velocity: (n,) present velocity, unit/s.
        acceleration: (n,) present acceleration, unit/s².
        arrived: whether the last target is reached; a path never arrives.
        at_home: whether it is at home, at rest, and not about to leave.
    """

    def __init__(
        self,
        home: np.ndarray | float,
        *,
        speed: np.ndarray | float,
        acceleration: np.ndarray | float,
    ) -> None:
        self.home = np.atleast_1d(np.array(home, dtype=float))
        n = self.home.size
        self._speed = np.broadcast_to(np.asarray(speed, dtype=float), (n,))
        self._limit = np.broadcast_to(np.asarray(acceleration, dtype=float), (n,))
        self._still = np.zeros(n)
        self._dt = _DT
        self.reset()

    def reset(self) -> None:
        """Be at home and at rest at once."""
        n = self.home.size
        self.value = self.home.copy()
        self.velocity = np.zeros(n)
        self.acceleration = np.zeros(n)
        self.arrived = self.at_home = True
        self._goal = self.home.copy()
        self._path: Path | None = None
        self._since = self._blend = 0.0
        self._decay: tuple[np.ndarray, ...] = (self._still,) * 6
        self._points: deque[np.ndarray] = deque()

    def start_from(self, value: np.ndarray, velocity: np.ndarray) -> None:
        """Take a value and velocity at once: only where nothing has been commanded before."""
        self.reset()
        self.value, self.velocity = self._vector(value), self._vector(velocity)
        self._goal, self.arrived, self.at_home = self.value.copy(), False, False

    def move_home(self, home: np.ndarray) -> None:
        """Change home; a reference that is at home jumps there, so it must be near.

        Raises:
            MotionError: see `move_to`.
        """
        self.home = self._vector(home)
        if self.at_home:
            self.reset()

    @property
    def goal(self) -> np.ndarray:
        """(n,) target of the last `move_to`, or the present position of the path."""
        return self._goal if self._path is None else self._path(self._since)

    def move_to(self, target: np.ndarray | float, duration: float = 0.0) -> float:
        """Move to a value and stay there.

        Args:
            target: (n,) or a number for all components.
            duration: s; longer when the limits of speed and acceleration ask for it.

        Returns:
            How long the motion takes, s.

        Raises:
            MotionError: a wrong shape, a value that is not finite, or one that is too far off.
        """
        goal = self._vector(target)
        e = self.value - goal
        if not (e.any() or self.velocity.any() or self.acceleration.any()):
            self._goal, self._path = goal, None
            self._arrive()
            return 0.0
        difference = (e, self.velocity, self.acceleration)
        time = self._duration_within_limits(difference, max(duration, 0.02))
        if time > max(duration, _MAX_DURATION) and not np.array_equal(goal, self.home):
            raise MotionError(
                f"a reference is to move by {np.abs(e).max():.4g}: within its limits of speed and "
                f"acceleration that takes more than {_MAX_DURATION:g} s"
            )
        self._start(None, goal, difference, time)
        return time

    def follow(self, path: Path, blend: float = 0.6) -> None:
        """Follow a path, from its time 0 on.

        Args:
            path: time, s -> (n,) position; smooth, and defined a little before 0 too. Velocity
                and acceleration are taken by central differences.
            blend: time within which the present difference to the path decays, s; longer when
                the limits of speed and acceleration ask for it.

        Raises:
            MotionError: the path gives a wrong shape, or a value that is not finite.
        """
        self._vector(path(0.0))
        self._since = 0.0
        self._points.clear()
        p, v, a = self._along(path)
        difference = (self.value - p, self.velocity - v, self.acceleration - a)
        self._start(path, self.home, difference, self._duration_within_limits(difference, blend))

    def advance(self, dt: float) -> None:
        """Advance by a tick of dt, s."""
        if self.arrived:
            return
        if dt != self._dt:
            self._dt = dt
            self._points.clear()
        self._since += dt
        time = self._since
        if self._path is None:
            if time >= self._blend:
                self.value = self._goal.copy()
                self.velocity = np.zeros(self.value.size)
                self.acceleration = np.zeros(self.value.size)
                self._arrive()
                return
            x, v, a = self._goal, self._still, self._still
        else:
            x, v, a = self._along(self._path)
            if time >= self._blend:
                self.value, self.velocity, self.acceleration = x, v, a
                return
        r, dr, ddr = evaluate_quintic(self._decay, time / self._blend)
        self.value = x + r
        self.velocity = v + dr / self._blend
        self.acceleration = a + ddr / self._blend**2

    def _along(self, path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration of a path now, by central differences.

        Ticks are equidistant, so each needs one new point of the path only.
        """
        points, time = self._points, self._since
        if not points:
            reach = range(-_HALF_WIDTH, _HALF_WIDTH + 1)
            points.extend(self._point(path, time + k * self._dt) for k in reach)
        else:
            points.append(self._point(path, time + _HALF_WIDTH * self._dt))
            points.popleft()
        before, now, after = points[0], points[_HALF_WIDTH], points[-1]
        h = _HALF_WIDTH * self._dt
        bound = _CORNER * self._limit  # a path with a corner has no acceleration there
        acceleration = (after - 2.0 * now + before) / (h * h)
        return (
            now,
            (after - before) / (2.0 * h),
            np.minimum(np.maximum(acceleration, -bound), bound),
        )

    def _point(self, path: Path, time: float) -> np.ndarray:
        point = np.asarray(path(time), dtype=float)
        if point.shape != self.home.shape or not np.isfinite(point).all():
            raise MotionError(
                f"a path gave {point} at {time:.3f} s: it needs {self.home.size} finite numbers"
            )
        return point

    def _decay_to(self, goal: np.ndarray, time: float) -> tuple[np.ndarray, ...]:
        """Return the coefficients of the difference to a target that decays within a time, s."""
        return quintic_coefficients(
            self.value - goal, self.velocity * time, self.acceleration * time**2, 0.0
        )

    def _difference_at(self, time: float) -> np.ndarray:
        """Return the difference to the path that remains at a time, see `follow`."""
        share = min(max(time / self._blend, 0.0), 1.0)
        return np.asarray(evaluate_quintic(self._decay, share)[0])

    def _start(
        self,
        path: Path | None,
        goal: np.ndarray,
        difference: _Difference,
        blend: float,
    ) -> None:
        self._path, self._goal = path, goal
        self._decay = _decay_coefficients(difference, blend)
        self._since, self._blend, self.arrived, self.at_home = 0.0, blend, False, False

    def _arrive(self) -> None:
        self.arrived, self.at_home = True, np.array_equal(self._goal, self.home)

    def _duration_within_limits(self, difference: _Difference, time: float) -> float:
        """Return the least duration from `time` on in which a difference decays within the limits.

        If there is none, the one that exceeds them least: longer is not always gentler, because
        what moves already moves farther meanwhile.
        """
        best, least = time, np.inf
        while time < _SEARCH_END:
            _, dr, ddr = evaluate_quintic(_decay_coefficients(difference, time), SAMPLES)
            speed = float((np.abs(dr) / (self._speed * time)).max())
            excess = max(speed, float((np.abs(ddr) / (self._limit * time**2)).max()))
            if excess < least:
                best, least = time, excess
            if excess <= 1.0:
                break
            time *= _STRETCH
        return best

    def _vector(self, value: np.ndarray | float) -> np.ndarray:
        n = self.home.size
        array = np.asarray(value, dtype=float)
        if array.ndim == 0:
            array = np.full(n, float(array))
        if array.shape != (n,):
            raise MotionError(f"a reference of {n} numbers was given {array.shape}")
        if not np.isfinite(array).all():
            raise MotionError(f"a reference was given {array}: it must be finite")
        return array.copy()


def _decay_coefficients(difference: _Difference, time: float) -> tuple[np.ndarray, ...]:
    """Return the coefficients of the quintic that brings a difference to rest at 0 in a time."""
    e, v, a = difference
    return quintic_coefficients(e, v * time, a * time**2, 0.0)
