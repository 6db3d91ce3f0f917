"""Joint position limit with braking distance."""

from __future__ import annotations

import numpy as np

from wbc.errors import LimitError
from wbc.kinematics import Kinematics
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.per_joint import default_braking, per_joint
from wbc.robot import RobotModel


def stopping_speed(
    distance: np.ndarray, braking: np.ndarray, dt: float, recovery: float
) -> np.ndarray:
    """Return the largest speed towards a limit from which it is not overrun, rad/s.

    Steps of velocity that are braked by a_b dt each cover `(k+1) w dt − k (k+1)/2 a_b dt²` for
    k a_b dt ≤ w ≤ (k+1) a_b dt. The largest w that covers no more than the distance d is

        w = d/((k+1) dt) + k a_b dt/2,   k = ⌊(√(1 + 8 d/(a_b dt²)) − 1)/2⌋,

    the discrete form of w = √(2 a_b d) (Del Prete 2018, for velocity control). Beyond the limit
    it is d/recovery, a speed away from it.

    Args:
        distance: d, to the limit, negative beyond it, rad.
        braking: a_b, rad/s²; infinite for d/dt.
        dt: duration of a step, s.
        recovery: time within which a joint that is beyond is brought back, s.
    """
    unit = braking * (dt * dt)
    inside = np.maximum(distance, 0.0)
    with np.errstate(invalid="ignore"):  # a joint without limits: ∞
        k = np.floor(0.5 * (np.sqrt(1.0 + 8.0 * inside / unit) - 1.0))
        speed = (inside / (k + 1.0)) / dt + np.where(k > 0.0, 0.5 * k * unit / dt, 0.0)
    speed = np.where(np.isinf(inside), np.inf, speed)
    return np.asarray(np.where(distance < 0.0, distance / max(recovery, dt), speed))


class JointPositionLimit(AccelerationBound):
    """Keeps every joint able to stop before its limit.

    A state is viable when a deceleration a_b stops the joint in time: with d the distance to
    the limit (less a margin) and v the velocity towards it, `v ≤ √(2 a_b d)`. The largest
    acceleration is the one that, held for a time T, ends in a viable state,

        a = (w − v) / T,   w = √((a_b T/2)² + a_b (2 d − T v)) − a_b T/2   where 2 d ≥ T v.

    The viable set is convex in (position, velocity) and full braking never leaves it, so that
    a joint that is in it stays in it, with decelerations of at most a_b, for every control
    period up to T (after Del Prete, Joint position and velocity bounds in discrete-time
    acceleration/torque control of robot manipulators, RA-L 2018, who takes the control period
    for T). A T of several periods keeps measurement noise out of the accelerations: they
    change by 2/T per rad/s and 2/T² per rad at most.

    Nearer or faster than that the same law goes on linearly, `a = 2 (d − T v) / T²` (damping
    ratio 0.7), and beyond the limit gently, `a = 2 (d / recovery − v) / T`: the last stretch
    to the limit, d ≤ a_b T²/2, is passed by at most a third of it (1.3 mrad at the default
    values, which the margin covers). More than a_b is never demanded: a limit that asks for
    more than the motors can give would leave the QP without a solution.

    Args:
        robot: the robot.
        margin: distance kept from the limits, rad.
        braking: a_b, rad/s², a number or (na,); `default_braking` when left out.
        horizon: T, s; not shorter than the control period.
        recovery: time within which a joint that is beyond is brought back, s; at least T.

    Raises:
        LimitError: a negative margin, a braking or horizon that is not positive, or a
            recovery below the horizon.
    """

    name = "joint position limit"

    def __init__(
        self,
        robot: RobotModel,
        *,
        margin: float = 0.02,
        braking: float | np.ndarray | None = None,
        horizon: float = 0.02,
        recovery: float = 0.2,
    ) -> None:
        if not margin >= 0.0:
            raise LimitError(f"{self.name}: margin {margin} rad must not be negative")
        super().__init__(horizon)
        if not recovery >= horizon:
            raise LimitError(
                f"{self.name}: recovery {recovery} s must not be below the horizon {horizon} s"
            )
        # A joint with a small range keeps at least half of it.
        margins = np.minimum(margin, 0.25 * (robot.q_max - robot.q_min))
        self.lower = robot.q_min + margins
        self.upper = robot.q_max - margins
        self.lower.setflags(write=False)
        self.upper.setflags(write=False)
        braking = default_braking(robot) if braking is None else braking
        self.braking = per_joint(self.name, "braking", braking, robot)
        self.recovery = recovery
        self._margin = margin
        self._half = 0.5 * horizon * self.braking
        self._distance, self._velocity = np.empty((2, robot.na)), np.empty((2, robot.na))

    def __repr__(self) -> str:
        return f"JointPositionLimit(margin {self._margin:g} rad, horizon {self.horizon:g} s)"

    def velocity_bounds(
        self, kin: Kinematics, v: np.ndarray, dt: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocities from which a joint stops before its limit; see `stopping_speed`.

        A joint that is beyond its limit is brought back within `recovery`.
        """
        q = kin.state.q[7:]
        low = stopping_speed(q - self.lower, self.braking, dt, self.recovery)
        high = stopping_speed(self.upper - q, self.braking, dt, self.recovery)
        return -low, high

    def bounds(self, kin: Kinematics) -> tuple[np.ndarray, np.ndarray]:
        """See `AccelerationBound`."""
        q, v = kin.state.q[7:], kin.state.v[6:]
        d, towards = self._distance, self._velocity
        np.subtract(q, self.lower, out=d[0])
        np.subtract(self.upper, q, out=d[1])
        np.negative(v, out=towards[0])
        towards[1] = v
        a = self._largest(d, towards)
        return -a[0], a[1]

    def _largest(self, d: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the largest acceleration towards the lower and the upper limit, (2, na)."""
        T, braking = self.horizon, self.braking
        clearance = 2.0 * np.maximum(d, (T / self.recovery) * d)  # the latter where d < 0
        clearance -= T * v
        a = np.maximum(clearance, 0.0)
        a *= braking
        a += self._half * self._half
        np.sqrt(a, out=a)
        a -= self._half
        np.minimum(clearance, 0.0, out=clearance)
        clearance /= T
        a += clearance
        a -= v
        a /= T
        return np.asarray(np.maximum(a, -braking, out=a))
