"""References whose value, velocity and acceleration never jump, whatever is asked of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from wbc.errors import MotionError
from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients

#: Position of a reference over time since it was begun, s -> (n,).
Path = Callable[[float], np.ndarray]

#: What is left of the difference to a goal or path, its velocity and its acceleration.
_Left = tuple[np.ndarray, np.ndarray, np.ndarray]

_DT = 0.002  # s, until the first tick tells
_REACH = 2  # ticks to either side, of the central differences along a path
_CORNER = 5.0  # times the limit of acceleration
SAMPLES = np.linspace(0.0, 1.0, 15)[:, None]
_LONGER = 1.15  # by how much a duration grows until it suits the limits
_LONGEST = 60.0  # s
_TOO_LONG = 30.0  # s


class SmoothReference:
    """A vector that goes where it is told, twice continuously differentiable in time.

    It is a path plus what is left of the difference at the moment when the path was begun,

        x(t) = p(t) + r(t),   r(0) = x₀ − p(0),   r(T) = ṙ(T) = r̈(T) = 0,

    with r the quintic that also starts with the differences of velocity and acceleration. So
    any order may be replaced by another at any time: value, velocity and acceleration go on
    from where they are.

    Args:
        home: (n,) where it starts.
        speed: largest |ẋ| of a `go`, per component, unit/s.
        acceleration: likewise |ẍ|, unit/s².

    Attributes:
        home: (n,).
        value: (n,) now.
        velocity: (n,) per s.
        acceleration: (n,) per s².
        arrived: the last order is carried out; a path is followed for good and never arrives.
        at_home: at home, at rest, and not about to leave.
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
        """At home, at rest, at once."""
        n = self.home.size
        self.value = self.home.copy()
        self.velocity = np.zeros(n)
        self.acceleration = np.zeros(n)
        self.arrived = self.at_home = True
        self._goal = self.home.copy()
        self._path: Path | None = None
        self._since = self._blend = 0.0
        self._left: tuple[np.ndarray, ...] = (self._still,) * 6
        self._points: deque[np.ndarray] = deque()

    def start_from(self, value: np.ndarray, velocity: np.ndarray) -> None:
        """Be somewhere at once, moving: only where nothing has been commanded before."""
        self.reset()
        self.value, self.velocity = self._vector(value), self._vector(velocity)
        self._goal, self.arrived, self.at_home = self.value.copy(), False, False

    def move_home(self, home: np.ndarray) -> None:
        """Home is there from now on; who is there goes along at once, so it must be near.

        Raises:
            MotionError: see `go`.
        """
        self.home = self._vector(home)
        if self.at_home:
            self.reset()

    @property
    def goal(self) -> np.ndarray:
        """(n,) where the last `go` leads; where a path is now."""
        return self._goal if self._path is None else self._path(self._since)

    def go(self, target: np.ndarray | float, duration: float = 0.0) -> float:
        """Go to a value and stay; returns how long it takes, s.

        Args:
            target: (n,) or a number for all components.
            duration: s; longer when the limits of speed and acceleration ask for it.

        Raises:
            MotionError: a wrong shape, a value that is not finite, or one that is too far off.
        """
        goal = self._vector(target)
        e = self.value - goal
        if not (e.any() or self.velocity.any() or self.acceleration.any()):
            self._goal, self._path = goal, None
            self._arrive()
            return 0.0
        left = (e, self.velocity, self.acceleration)
        time = self._suited(left, max(duration, 0.02))
        if time > max(duration, _TOO_LONG) and not np.array_equal(goal, self.home):
            raise MotionError(
                f"a reference is to go {np.abs(e).max():.4g} far: within its limits of speed and "
                f"acceleration that takes more than {_TOO_LONG:g} s"
            )
        self._start(None, goal, left, time)
        return time

    def follow(self, path: Path, blend: float = 0.6) -> None:
        """Follow a path from its time 0 on.

        Args:
            path: time in s -> (n,) position, smooth and defined a little before 0 too;
                velocity and acceleration are taken by central differences.
            blend: within which the present difference to the path fades, s; longer when the
                limits of speed and acceleration ask for it.

        Raises:
            MotionError: the path gives a wrong shape, or a value that is not finite.
        """
        self._vector(path(0.0))
        self._since = 0.0
        self._points.clear()
        p, v, a = self._along(path)
        left = (self.value - p, self.velocity - v, self.acceleration - a)
        self._start(path, self.home, left, self._suited(left, blend))

    def advance(self, dt: float) -> None:
        """Move on by dt, s."""
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
        r, dr, ddr = evaluate_quintic(self._left, time / self._blend)
        self.value = x + r
        self.velocity = v + dr / self._blend
        self.acceleration = a + ddr / self._blend**2

    def _along(self, path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity and acceleration of a path now, by central differences.

        Ticks follow one another at the same distance: each needs one more point of the path.
        """
        points, time = self._points, self._since
        if not points:
            reach = range(-_REACH, _REACH + 1)
            points.extend(self._point(path, time + k * self._dt) for k in reach)
        else:
            points.append(self._point(path, time + _REACH * self._dt))
            points.popleft()
        before, now, after = points[0], points[_REACH], points[-1]
        h = _REACH * self._dt
        most = _CORNER * self._limit  # a path with a corner has no acceleration there
        bend = (after - 2.0 * now + before) / (h * h)
        return now, (after - before) / (2.0 * h), np.minimum(np.maximum(bend, -most), most)

    def _point(self, path: Path, time: float) -> np.ndarray:
        point = np.asarray(path(time), dtype=float)
        if point.shape != self.home.shape or not np.isfinite(point).all():
            raise MotionError(
                f"a path gave {point} at {time:.3f} s: it needs {self.home.size} finite numbers"
            )
        return point

    def _way(self, goal: np.ndarray, time: float) -> tuple[np.ndarray, ...]:
        """(6, n) coefficients of what is left of the way to a goal, see `quintic`."""
        return quintic_coefficients(
            self.value - goal, self.velocity * time, self.acceleration * time**2, 0.0
        )

    def _rest_at(self, time: float) -> np.ndarray:
        """(n,) what is left then of the difference to the path, see `follow`."""
        share = min(max(time / self._blend, 0.0), 1.0)
        return np.asarray(evaluate_quintic(self._left, share)[0])

    def _start(
        self,
        path: Path | None,
        goal: np.ndarray,
        left: _Left,
        blend: float,
    ) -> None:
        self._path, self._goal = path, goal
        self._left = _decay(left, blend)
        self._since, self._blend, self.arrived, self.at_home = 0.0, blend, False, False

    def _arrive(self) -> None:
        self.arrived, self.at_home = True, np.array_equal(self._goal, self.home)

    def _suited(self, left: _Left, time: float) -> float:
        """The least duration from `time` on in which what is left fades within the limits.

        Or the one that comes nearest to it: longer is not always gentler, what moves already
        goes on farther meanwhile.
        """
        best, least = time, np.inf
        while time < _LONGEST:
            _, dr, ddr = evaluate_quintic(_decay(left, time), SAMPLES)
            speed = float((np.abs(dr) / (self._speed * time)).max())
            excess = max(speed, float((np.abs(ddr) / (self._limit * time**2)).max()))
            if excess < least:
                best, least = time, excess
            if excess <= 1.0:
                break
            time *= _LONGER
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


def _decay(difference: _Left, time: float) -> tuple[np.ndarray, ...]:
    """Return the coefficients of the quintic that brings a difference to rest at 0 in a time."""
    e, v, a = difference
    return quintic_coefficients(e, v * time, a * time**2, 0.0)
