"""Contact-aided right-invariant extended Kalman filter of a body with an IMU.

R. Hartley, M. Ghaffari, R. Eustice, J. Grizzle, "Contact-aided invariant extended
Kalman filtering for robot state estimation", IJRR 39(4), 2020; the soles' orientations
after M. Bloesch et al., "State estimation for legged robots on unstable and slippery
terrain", IROS 2013.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from wbc.estimation.correction import Correction
from wbc.estimation.noise import EstimatorNoise

_R, _V, _P = slice(0, 3), slice(3, 6), slice(6, 9)

#: (3, 9) `a.dot(_SKEW)` is the matrix of `a ×`, row by row; so for many a at once.
_SKEW = np.array([pin.skew(axis).ravel() for axis in np.eye(3)])

#: Corrections between two rounds of `_tidy`.
_TIDY = 20


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
        vectors: (2 + n, 3) in world axes: velocity of the IMU, m/s; its position; the
            sole centres, m; positions are relative to the IMU's place at the reset.
        F: (n, 3, 3) sole axes to world axes.
        gyro_bias: (3,) IMU axes, rad/s.
        accelerometer_bias: (3,) IMU axes, m/s².
        P: covariance of `[ξ_R, ξ_v, ξ_p, ξ_d…, ξ_F…, b_g, b_a]`.

    Args:
        feet: how many.
        dt: period of the IMU, s.
        gravity: (3,) world axes, m/s².
        noise: what is assumed of the sensors.
        covariances: per foot (6, 6) of its pose as the encoders see it: position, then
            rotation vector, IMU axes; m, rad.
        every: periods between two corrections, over which the covariance takes one step.
    """

    def __init__(
        self,
        feet: int,
        dt: float,
        gravity: np.ndarray,
        noise: EstimatorNoise,
        covariances: Sequence[np.ndarray],
        every: int = 1,
    ) -> None:
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
        self._every = every
        self._transitions: dict[int, np.ndarray] = {}
        # How a gyro error in world axes moves the errors: [I; v×; p×; d×].
        self._lever = np.zeros((self._moved, 3))
        self._lever[_R] = np.eye(3)
        self._skews = self._lever[3:].reshape(-1, 9)
        self.vectors = np.zeros((2 + feet, 3))
        # A period on, [v, p] is coast [v, p] + kick a.
        self._body = self.vectors[:2]
        self._coast = np.array([[1.0, 0.0], [dt, 1.0]])
        self._kick = np.array([[dt], [0.5 * dt * dt]])
        # What a period adds to the covariance: by the gyro, by a foot that wanders, by the rest.
        self._gyro_step = (noise.gyro * dt) ** 2
        self._wandering = np.zeros((n, feet))
        twist = dt * np.square([noise.rock, noise.rock, noise.twist])
        for i in range(feet):
            self._wandering[self._place[i], i] = noise.slip**2 * dt
            self._wandering[self._turn[i], i] = twist
        self._process = np.zeros(n)
        self._process[_V] = (noise.accelerometer * dt) ** 2
        self._process[self._bg] = noise.gyro_walk**2 * dt
        self._process[self._ba] = noise.accelerometer_walk**2 * dt
        self._diagonal = self.P.reshape(-1)[:: n + 1]
        self._updates = {
            key: Correction(key, n, self._place, self._turn, covariances)
            for size in range(1, feet + 1)
            for key in itertools.combinations(range(feet), size)
        }
        self.reset(np.eye(3), np.zeros(3))

    @property
    def v(self) -> np.ndarray:
        """(3,) velocity of the IMU, world axes, m/s."""
        velocity: np.ndarray = self.vectors[0]
        return velocity

    @property
    def p(self) -> np.ndarray:
        """(3,) position of the IMU relative to its place at the reset, world axes, m."""
        place: np.ndarray = self.vectors[1]
        return place

    def reset(self, R: np.ndarray, v: np.ndarray) -> None:
        """Start at a pose and velocity, with unknown biases and no feet on the ground."""
        noise = self._noise
        self.R = np.array(R, dtype=float)
        self.vectors[:] = 0.0
        self.vectors[0] = v
        self.F = np.array([np.eye(3)] * self._feet)
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
        self._pending = self._corrections = 0
        self._wander = [0.0] * self._feet

    def propagate(self, gyro: np.ndarray, accelerometer: np.ndarray, slip: Sequence[float]) -> bool:
        """Advance by one period; tell whether a correction is due.

        Args:
            gyro: (3,) mean over the period, IMU axes, rad/s.
            accelerometer: (3,) mean specific force over the period, IMU axes, m/s².
            slip: per foot, a factor on its wandering; 0 for a foot in the air.
        """
        half = pin.exp3((0.5 * self._dt) * (gyro - self.gyro_bias))
        middle = self.R.dot(half)
        acceleration = middle.dot(accelerometer - self.accelerometer_bias) + self._gravity
        self._body[:] = self._coast.dot(self._body) + self._kick * acceleration
        self.R = middle.dot(half)
        self._pending += 1
        for i, factor in enumerate(slip):
            self._wander[i] += factor * factor
        if self._pending < self._every:
            return False
        self._catch_up()
        return True

    def _catch_up(self) -> None:
        """Propagate the covariance over the periods since it was last."""
        count = self._pending
        if count == 0:
            return
        self._pending = 0
        transition = self._transitions.get(count)
        if transition is None:
            transition = self._transitions[count] = self._transition_over(count * self._dt)
        minus = (-count * self._dt) * self.R
        self.vectors.dot(_SKEW, out=self._skews)
        lever, moved = self._lever, self._moved
        transition[:moved, self._bg] = lever.dot(minus)
        transition[_V, self._ba] = minus
        P = self.P
        transition.dot(P).dot(transition.T, out=P)
        P[:moved, :moved] += (count * self._gyro_step) * lever.dot(lever.T)
        self._diagonal += count * self._process + self._wandering.dot(self._wander)
        self._wander = [0.0] * self._feet

    def _transition_over(self, time: float) -> np.ndarray:
        """The constant part of the errors' transition matrix."""
        transition = np.eye(len(self.P))
        transition[_P, _V] = time * np.eye(3)
        transition[_V, _R] = time * pin.skew(self._gravity)
        transition[_P, _R] = 0.5 * time * transition[_V, _R]
        return transition

    def land(self, foot: int, h: np.ndarray, F: np.ndarray) -> None:
        """Take a sole as standing where the legs say it is now.

        Args:
            foot: its index.
            h: (3,) sole centre in IMU axes, m.
            F: (3, 3) sole axes to IMU axes.
        """
        self._catch_up()
        self.vectors[2 + foot] = self.p + self.R @ h
        self.F[foot] = self.R @ F
        P = self.P
        place, turn = self._place[foot], self._turn[foot]
        for own, source in ((place, _P), (turn, _R)):
            P[own, :] = P[source, :]
            P[:, own] = P[:, source]
        update = self._updates[(foot,)]
        update.turn_noise(self.R)
        N = update.N
        P[place, place] += N[:3, :3]
        P[turn, turn] += N[3:, 3:]
        P[place, turn] += N[:3, 3:]
        P[turn, place] += N[3:, :3]

    def correct(self, feet: tuple[int, ...], h: np.ndarray, F: np.ndarray) -> None:
        """Correct by soles that stand still, as the legs see them.

        Innovations too large to be noise mean that a sole has slipped: the least likely
        one is taken in anew where it is, and nothing else is corrected this time.

        Args:
            feet: their indices, ascending.
            h: (k, 3) sole centres in IMU axes, m.
            F: (k, 3, 3) sole axes to IMU axes.
        """
        if not feet:
            return
        R, P, X = self.R, self.P, self.vectors
        update = self._updates[feet]
        n = len(P)
        both = update.both
        both[:, :n] = HP = update.H.dot(P)
        r = both[:, n]
        off = h.dot(R.T) + X[1]
        for k, i in enumerate(feet):
            update.places[k][:] = off[k] - X[2 + i]
            # Of R F F̂ᵀ, a rotation by milliradians, sine and angle are the same.
            (_, b, c), (d, _, e), (f, g, _) = R.dot(F[k]).dot(self.F[i].T).tolist()
            update.turns[k][:] = 0.5 * (g - e), 0.5 * (c - f), 0.5 * (d - b)
        update.turn_noise(R)
        S = HP.dot(update.H.T) + update.N
        solved = np.linalg.solve(S, both)  # S⁻¹ [H P, r]
        weighted = solved[:, n]
        unlikely = np.add.reduceat(r * weighted, update.starts).tolist()
        if max(unlikely) > self._noise.slip_gate:
            # Taken for truth, the slip of a sole would turn into a bias of the gyro.
            k = unlikely.index(max(unlikely))
            self.land(feet[k], h[k], F[k])
            return
        self._retract(-weighted.dot(HP))
        P -= HP.T.dot(solved[:, :n])
        self._corrections += 1
        if self._corrections % _TIDY == 0:
            self._tidy()

    def _tidy(self) -> None:
        """Take out what rounding has piled up: P stays symmetric, R and F rotations."""
        self.P += self.P.T.copy()
        self.P *= 0.5
        # One Newton step of the polar decomposition.
        self.R = 1.5 * self.R - 0.5 * (self.R @ (self.R.T @ self.R))
        self.F = 1.5 * self.F - 0.5 * (self.F @ (self.F.transpose(0, 2, 1) @ self.F))

    def _retract(self, xi: np.ndarray) -> None:
        """Left-multiply the estimate by exp(ξ)."""
        # Γ₀ and Γ₁ of the group of double direct isometries: exp(a) and ∫₀¹ exp(s a) ds.
        turn, smear = pin.exp3(xi[_R]), pin.Jexp3(-xi[_R])
        self.R = turn.dot(self.R)
        moves = xi[3 : self._moved].reshape(-1, 3)
        self.vectors[:] = self.vectors.dot(turn.T) + moves.dot(smear.T)
        for F, own in zip(self.F, self._turn, strict=True):
            F[:] = pin.exp3(xi[own]).dot(F)
        self.gyro_bias = self.gyro_bias + xi[self._bg]
        self.accelerometer_bias = self.accelerometer_bias + xi[self._ba]
