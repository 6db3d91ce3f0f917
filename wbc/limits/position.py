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

    A state is viable when a deceleration of at most a_b stops the joint in time. With d the
    distance to the limit (less a margin), v the velocity towards it and ω = 1/(2T), the states

        v ≤ φ(d),   φ = ω d up to d = a_b/ω², beyond it φ = √(2 a_b d − (a_b/ω)²),

    are viable, and the largest acceleration is

        a = ω (φ − v) − φ' v.

    φ φ' never exceeds a_b and φ is concave: for every control period up to T, whatever is done
    within the bounds, a joint that starts in such a state stays in it, never passes its limit, and
    is never asked for a deceleration of more than a_b; nor do the bounds of its two limits
    exclude each other, or those of a limit on velocities (after Del Prete, Joint position and
    velocity bounds in discrete-time acceleration/torque control of robot manipulators, RA-L
    2018; rounded near the limit, as there the deceleration of his bounds jumps by a_b with the
    sign of the velocity's measurement noise). As the joint approaches its limit the bounds change
    by at most 1/T per rad/s and 1/(2T²) per rad.

    A joint that is faster brakes with a_b, and one that is beyond its limit comes back with
    `φ = d / recovery`: a limit that asks for more than the motors can give would leave the QP
    without a solution.

    Args:
        robot: the robot.
        margin: distance kept from the limits, rad.
        braking: a_b, rad/s², a number or (na,); `default_braking` when left out.
        horizon: T, s; not shorter than the control period.
        recovery: time within which a joint that is beyond is brought back, s; at least 2 T.

    Raises:
        LimitError: a negative margin, a braking or horizon that is not positive, or a
            recovery below twice the horizon.
    """

    name = "joint position limit"

    def __init__(
        self,
        robot: RobotModel,
        *,
        margin: float = 0.02,
        braking: float | np.ndarray | None = None,
        horizon: float = 0.01,
        recovery: float = 0.2,
    ) -> None:
        if not margin >= 0.0:
            raise LimitError(f"{self.name}: margin {margin} rad must not be negative")
        super().__init__(horizon)
        if not recovery >= 2.0 * horizon:
            raise LimitError(
                f"{self.name}: recovery {recovery} s must not be below twice the horizon, "
                f"{2.0 * horizon} s"
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
        braking, rate = self.braking, 0.5 / self.horizon
        speed = braking / rate  # where φ passes from the line to the root
        root = np.sqrt(np.maximum(2.0 * braking * d - speed * speed, speed * speed))
        slope = braking / root
        phi = root + slope * np.minimum(d - speed / rate, 0.0)
        beyond = d < 0.0
        if beyond.any():
            phi[beyond], slope[beyond] = d[beyond] / self.recovery, 1.0 / self.recovery
        return np.asarray(np.maximum(rate * (phi - v) - slope * v, -braking))
