"""Contact-aided right-invariant extended Kalman filter of a body with an IMU.

R. Hartley, M. Ghaffari, R. Eustice, J. Grizzle, "Contact-aided invariant extended
Kalman filtering for robot state estimation", IJRR 39(4), 2020; the soles' orientations
after M. Bloesch et al., "State estimation for legged robots on unstable and slippery
terrain", IROS 2013.
"""

from __future__ import annotations

import math

import numpy as np

from wbc.estimation import so3
from wbc.estimation.noise import EstimatorNoise

_R, _V, _P = slice(0, 3), slice(3, 6), slice(6, 9)


class InvariantFilter:
    """Orientation, velocity and position of an IMU, the feet it stands on, its biases.

    The state is `X = (R, v, p, d₁ … d_n)` in SE_{2+n}(3), the soles' orientations
    `F₁ … F_n` in SO(3) and the biases. Errors are right-invariant, `X̂ = exp(ξ) X`, in
    world axes, and their linear dynamics

        ξ̇_R = −R b_g,   ξ̇_v = g × ξ_R − v × R b_g − R b_a,
        ξ̇_p = ξ_v − p × R b_g,   ξ̇_d = −d × R b_g,   ξ̇_F = 0

    depend on the estimate through the biases alone; a foot measured through the legs,
    `r = p + R h − d = ξ_p − ξ_d + noise`, not at all. Moving or turning the scene
    changes nothing but its coordinates.

    Attributes:
        R: (3, 3) IMU axes to world axes.
        v: (3,) velocity of the IMU, world axes, m/s.
        p: (3,) its position relative to the place of the reset, world axes, m.
        gyro_bias: (3,) IMU axes, rad/s.
        accelerometer_bias: (3,) IMU axes, m/s².

    Args:
        feet: how many.
        dt: period of the IMU, s.
        gravity: (3,) world axes, m/s².
        noise: what is assumed of the sensors.
    """

    def __init__(self, feet: int, dt: float, gravity: np.ndarray, noise: EstimatorNoise) -> None:
        self._feet = feet
        self._dt = dt
        self._gravity = np.array(gravity, dtype=float)
        self._noise = noise
        n = 9 + 6 * feet + 6
        self._place = [slice(9 + 3 * i, 12 + 3 * i) for i in range(feet)]
        self._turn = [slice(9 + 3 * (feet + i), 12 + 3 * (feet + i)) for i in range(feet)]
        self._bg, self._ba = slice(n - 6, n - 3), slice(n - 3, n)
        self._moved = 9 + 3 * feet  # rows that a gyro error moves
        self.P = np.zeros((n, n))
        self._transition = np.eye(n)
        self._transition[_P, _V] = dt * np.eye(3)
        so3.skew(dt * self._gravity, self._transition[_V, _R])
        so3.skew(0.5 * dt * dt * self._gravity, self._transition[_P, _R])
        # How a gyro error in world axes moves the errors: [I; v×; p×; d×].
        self._lever = np.zeros((self._moved, 3))
        self._lever[_R] = np.eye(3)
        self._process = np.zeros(n)
        self._process[_V] = (noise.accelerometer * dt) ** 2
        self._process[self._bg] = noise.gyro_walk**2 * dt
        self._process[self._ba] = noise.accelerometer_walk**2 * dt
        self._diagonal = self.P.reshape(-1)[:: n + 1]
        self.d = [np.zeros(3) for _ in range(feet)]
        self.F = [np.eye(3) for _ in range(feet)]
        self.reset(np.eye(3), np.zeros(3))

    def reset(self, R: np.ndarray, v: np.ndarray) -> None:
        """Start at a pose and velocity, with unknown biases and no feet on the ground."""
        noise = self._noise
        self.R = np.array(R, dtype=float)
        self.v = np.array(v, dtype=float)
        self.p = np.zeros(3)
        self.gyro_bias = np.zeros(3)
        self.accelerometer_bias = np.zeros(3)
        self.P[:] = 0.0
        for block, sigma in (
            (_R, noise.tilt),
            (_V, noise.speed),
            (self._bg, noise.gyro_bias),
            (self._ba, noise.accelerometer_bias),
        ):
            self._diagonal[block] = sigma**2
        # Heading and place are what the reset says they are: nothing measures them.
        self._diagonal[2] = 0.0

    def propagate(self, gyro: np.ndarray, accelerometer: np.ndarray, slip: list[float]) -> None:
        """Advance by one period.

        Args:
            gyro: (3,) mean over the period, IMU axes, rad/s.
            accelerometer: (3,) mean specific force over the period, IMU axes, m/s².
            slip: per foot, a factor on its wandering; 0 for a foot in the air.
        """
        dt, noise = self._dt, self._noise
        turn = dt * (gyro - self.gyro_bias)
        acceleration = self.R @ (so3.exp(0.5 * turn) @ (accelerometer - self.accelerometer_bias))
        acceleration += self._gravity
        lever = self._lever
        so3.skew(self.v, lever[_V])
        so3.skew(self.p, lever[_P])
        for place, d in zip(self._place, self.d, strict=True):
            so3.skew(d, lever[place])
        transition = self._transition
        transition[: self._moved, self._bg] = lever @ (-dt * self.R)
        transition[_V, self._ba] = -dt * self.R
        self.P[:] = transition @ self.P @ transition.T
        self.P[: self._moved, : self._moved] += (noise.gyro * dt) ** 2 * (lever @ lever.T)
        for i, factor in enumerate(slip):
            self._process[self._place[i]] = (factor * noise.slip) ** 2 * dt
            self._process[self._turn[i]] = (factor * noise.twist) ** 2 * dt
        self._diagonal += self._process
        self.p = self.p + dt * (self.v + 0.5 * dt * acceleration)
        self.v = self.v + dt * acceleration
        self.R = self.R @ so3.exp(turn)

    def land(self, foot: int, h: np.ndarray, F: np.ndarray, covariance: np.ndarray) -> None:
        """Take a sole as standing where the legs say it is now.

        Args:
            foot: its index.
            h: (3,) sole centre in IMU axes, m.
            F: (3, 3) sole axes to IMU axes.
            covariance: (6, 6) of (h, rotation vector of F), IMU axes.
        """
        self.d[foot] = self.p + self.R @ h
        self.F[foot] = self.R @ F
        P = self.P
        for own, source in ((self._place[foot], _P), (self._turn[foot], _R)):
            P[own, :] = P[source, :]
            P[:, own] = P[:, source]
        place, turn = self._place[foot], self._turn[foot]
        R, C = self.R, covariance
        P[place, place] = P[_P, _P] + R @ C[:3, :3] @ R.T
        P[turn, turn] = P[_R, _R] + R @ C[3:, 3:] @ R.T
        cross = R @ C[:3, 3:] @ R.T
        P[place, turn] = P[_P, _R] + cross
        P[turn, place] = P[place, turn].T

    def correct(
        self,
        feet: list[int],
        h: list[np.ndarray],
        F: list[np.ndarray],
        covariances: list[np.ndarray],
    ) -> None:
        """Correct by soles that stand still, as the legs see them; arguments as in `land`."""
        if not feet:
            return
        m = 6 * len(feet)
        R, P = self.R, self.P
        residual = np.empty(m)
        HP = np.empty((m, P.shape[0]))
        N = np.zeros((m, m))
        for k, i in enumerate(feet):
            at, to = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            residual[at] = self.p + R @ h[k] - self.d[i]
            residual[to] = so3.log(R @ F[k] @ self.F[i].T)
            np.subtract(P[_P], P[self._place[i]], out=HP[at])
            np.subtract(P[_R], P[self._turn[i]], out=HP[to])
            C = (R @ covariances[k].reshape(2, 3, 2, 3).transpose(0, 2, 1, 3)) @ R.T
            N[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = C.transpose(0, 2, 1, 3).reshape(6, 6)
        S = N
        for k, i in enumerate(feet):
            at, to = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            S[:, at] += HP[:, _P] - HP[:, self._place[i]]
            S[:, to] += HP[:, _R] - HP[:, self._turn[i]]
        gain = np.linalg.solve(S, HP)  # (m, n): K transposed
        self._retract(-(residual @ gain))
        P -= HP.T @ gain
        # Rounding makes P lean; a symmetric one stays positive for hours.
        P += P.T.copy()
        P *= 0.5

    def _retract(self, xi: np.ndarray) -> None:
        """Left-multiply the estimate by exp(ξ)."""
        turn, smear = so3.exp_and_integral(xi[_R])
        self.R = _orthonormal(turn @ self.R)
        self.v = turn @ self.v + smear @ xi[_V]
        self.p = turn @ self.p + smear @ xi[_P]
        for i in range(self._feet):
            self.d[i] = turn @ self.d[i] + smear @ xi[self._place[i]]
            self.F[i] = so3.exp(xi[self._turn[i]]) @ self.F[i]
        self.gyro_bias = self.gyro_bias + xi[self._bg]
        self.accelerometer_bias = self.accelerometer_bias + xi[self._ba]

    def speed_deviation(self) -> float:
        """Standard deviation of one velocity component by the filter's own account, m/s."""
        return math.sqrt(float(self._diagonal[_V].sum()) / 3.0)


def _orthonormal(R: np.ndarray) -> np.ndarray:
    """R with the rounding of many products taken out: one Newton step of its polar part."""
    result: np.ndarray = 1.5 * R - 0.5 * (R @ (R.T @ R))
    return result
