"""Contact-aided right-invariant extended Kalman filter of a body with an IMU.

R. Hartley, M. Ghaffari, R. Eustice, J. Grizzle, "Contact-aided invariant extended
Kalman filtering for robot state estimation", IJRR 39(4), 2020; the soles' orientations
after M. Bloesch et al., "State estimation for legged robots on unstable and slippery
terrain", IROS 2013.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wbc.estimation.kernels import filter_record as layout
from wbc.estimation.kernels import inekf as kernels
from wbc.estimation.noise import EstimatorNoise

_SAME = 0.15  # m/s by which a velocity may change between two corrections, to count as the same
_LASTING = 2  # corrections for which soles seem to slip at the same velocity until it is a jump
_STILL = 2  # corrections without a slip, after which the next one is another
_ONSET = 2  # corrections in which a shock shows: the first one may come right after it
_STOOD = 2  # corrections that a sole has stood still since it landed, to tell of a shock at once
_SLIDES = 5  # corrections for which another one has to move at the same velocity, to tell of it
_FADING = 0.75  # share of its speed that a shock keeps until the next correction, at least
_LEVER = 0.15  # m from the centre of a sole to its edge, at most
_LEVER_ALONE = 2.0 * _LEVER  # m, the same of a sole whose motion no other one confirms
_TURNED = 0.1  # rad by which a shock may turn a sole


class InvariantFilter:
    """Orientation, velocity and position of an IMU, the soles it stands on, its biases.

    The state is `X = (R, v, p, d₁, …, dₙ)` in SEₙ₊₂(3), the orientations `F₁, …, Fₙ` of the n soles
    in SO(3) and the biases. Errors are right-invariant, `X̂ = exp(ξ) X`, in world axes, and their
    linear dynamics

        ξ̇_R = −R b_g,   ξ̇_v = g × ξ_R − v × R b_g − R b_a,
        ξ̇_p = ξ_v − p × R b_g,   ξ̇_d = −d × R b_g,   ξ̇_F = 0

    depend on the estimate through the biases alone; a sole measured through the legs,
    `r = p + R h − d = ξ_p − ξ_d + noise`, not at all. Moving or rotating the scene
    changes nothing but its coordinates.

    The state is one record, so that a copy or pickle of a filter is small and complete. The
    kernel `wbc.estimation.kernels.prediction.predict` propagates it.

    Args:
        dt: period of the IMU, s.
        gravity: (3,) world axes, m/s².
        noise: assumed noise of the sensors.
        covariances: per sole (6, 6) of its pose as the encoders see it: position, then
            rotation vector, IMU axes; m, rad.
        points: per sole, whether it touches the ground at a point, about which it turns; none
            does when left out.
        every: periods between two corrections, over which the covariance takes one step.

    Attributes:
        record: (1,) of the type `wbc.estimation.kernels.filter_record.filter_type`.
    """

    def __init__(
        self,
        dt: float,
        gravity: np.ndarray,
        noise: EstimatorNoise,
        covariances: Sequence[np.ndarray],
        points: Sequence[bool] | None = None,
        every: int = 1,
    ) -> None:
        self._noise = noise
        feet = len(covariances)
        self.record = record = np.zeros(1, layout.filter_type(feet))
        record["dt"], record["every"], record["gravity"] = dt, every, gravity
        record["early"] = early = (every + 1) // 2
        record["moved"] = noise.jump * early * dt
        record["slip_gate"] = noise.slip_gate
        record["leg_noise"] = covariances
        # What a period adds to the covariance: by the gyro, by the drift of a sole, by the rest.
        record["gyro_step"] = (noise.gyro * dt) ** 2
        rotation = dt * np.square([noise.rock, noise.rock, noise.twist])
        pivot = np.full(3, dt * noise.pivot**2)
        for foot, is_point in enumerate(points or [False] * feet):
            place = layout.FOOT_POSITION + 3 * foot
            turn = place + 3 * feet
            record["foot_drift"][0, place : place + 3, foot] = noise.slip**2 * dt
            record["foot_drift"][0, turn : turn + 3, foot] = pivot if is_point else rotation
        process = record["process"][0]
        process[layout.VELOCITY : layout.POSITION] = (noise.accelerometer * dt) ** 2
        process[layout.GYRO_BIAS : layout.ACCELEROMETER_BIAS] = noise.gyro_walk**2 * dt
        process[layout.ACCELEROMETER_BIAS :] = noise.accelerometer_walk**2 * dt
        self.reset(np.eye(3), np.zeros(3), np.zeros(3))

    def reset(self, R: np.ndarray, v: np.ndarray, origin: np.ndarray) -> None:
        """Start at a pose and velocity, with unknown biases and no sole on the ground.

        Args:
            R: (3, 3) IMU axes to world axes.
            v: (3,) velocity of the IMU, world axes, m/s.
            origin: (3,) position of the IMU, from which `p` counts, world axes, m.
        """
        record, noise = self.record, self._noise
        record["R"], record["F"] = R, np.eye(3)
        for name in ("vectors", "gyro_bias", "accelerometer_bias", "drift_factor", "slip_velocity"):
            record[name] = 0.0
        record["vectors"][0, 0] = v
        record["origin"] = origin
        for name in ("pending", "corrections", "started", "onset", "lasting", "still", "stood"):
            record[name] = 0
        sigma = np.zeros(record["xi"].size)
        # Heading and position are what the reset says they are: nothing measures them.
        sigma[:2] = noise.tilt
        sigma[layout.VELOCITY : layout.POSITION] = noise.speed
        sigma[layout.GYRO_BIAS : layout.ACCELEROMETER_BIAS] = noise.gyro_bias
        sigma[layout.ACCELEROMETER_BIAS :] = noise.accelerometer_bias
        record["P"] = np.diag(np.square(sigma))
        record["elapsed"] = record["every"] * record["dt"]

    @property
    def R(self) -> np.ndarray:
        """IMU axes to world axes, (3, 3)."""
        return self._field("R")

    @property
    def vectors(self) -> np.ndarray:
        """(2 + n, 3) world axes: velocity of the IMU, m/s; its position and the sole centres, m.

        Positions are relative to the IMU's at the reset.
        """
        return self._field("vectors")

    @property
    def v(self) -> np.ndarray:
        """Velocity of the IMU, (3,), world axes, m/s."""
        velocity: np.ndarray = self.vectors[0]
        return velocity

    @property
    def p(self) -> np.ndarray:
        """Position of the IMU relative to the one at the reset, (3,), world axes, m."""
        position: np.ndarray = self.vectors[1]
        return position

    @property
    def F(self) -> np.ndarray:
        """Sole axes to world axes, (n, 3, 3)."""
        return self._field("F")

    @property
    def gyro_bias(self) -> np.ndarray:
        """(3,) IMU axes, rad/s."""
        return self._field("gyro_bias")

    @property
    def accelerometer_bias(self) -> np.ndarray:
        """(3,) IMU axes, m/s²."""
        return self._field("accelerometer_bias")

    @property
    def P(self) -> np.ndarray:
        """Covariance of `[ξ_R, ξ_v, ξ_p, ξ_d₁…, ξ_F₁…, b_g, b_a]`, (15 + 6 n, 15 + 6 n)."""
        return self._field("P")

    def _field(self, name: str) -> np.ndarray:
        field: np.ndarray = self.record[name][0]
        return field

    def land(self, foot: int, h: np.ndarray, F: np.ndarray) -> None:
        """Take a sole as standing where the legs see it now.

        Args:
            foot: its index.
            h: (3,) sole centre in IMU axes, m.
            F: (3, 3) sole axes to IMU axes.
        """
        self.record["stood"][0, foot] = 0
        kernels.land(self.record, foot, h, F)

    def correct(self, held: np.ndarray, h: np.ndarray, F: np.ndarray) -> None:
        """Correct by soles that stand still, as the legs see them.

        Innovations too large to be noise mean that a sole has slipped: the least likely
        one is taken in anew where it is, and nothing else is corrected this time. But if all soles
        that stand are at `noise.jump` or more at once, and a velocity that is not known explains
        it, it is the robot that was moved, by a shock of more than the accelerometer can tell.
        Soles that have moved ever since they landed say so only if their velocity stays: one that
        slides or rolls when it lands is slower at each correction.

        The soles that stand stay where they are, in the mean: nothing measures where the robot is.
        Else what a step tells of the gyro's bias would turn all of the way behind the robot, and
        move it by decimetres once it is 100 m away.

        Args:
            held: (n,) whole numbers, 1 for a sole that stands still, else 0.
            h: (n, 3) sole centres in IMU axes, m.
            F: (n, 3, 3) sole axes to IMU axes.
        """
        record = self.record
        slipped = kernels.correct(record, held, h, F)
        if slipped < 0 or self._correct_for_jump(held, h, F):
            record["still"] += 1
            record["stood"] += held
            if record["still"][0] >= _STILL:
                record["onset"], record["slip_velocity"] = _ONSET, 0.0
            return
        record["still"] = 0
        # Taken for truth, the slip of a sole would turn into a bias of the gyro.
        shock = record["slip_velocity"].any()
        for foot in np.flatnonzero(held) if shock else (slipped,):
            kernels.land(record, foot, h[foot], F[foot])

    def _correct_for_jump(self, held: np.ndarray, h: np.ndarray, F: np.ndarray) -> bool:
        """Correct if the robot was moved and no sole has slipped; return whether it was."""
        record = self.record
        moved = record["residual"][0, : 6 * np.count_nonzero(held)].reshape(-1, 2, 3)
        way, turn = np.linalg.norm(moved, axis=2).T
        # A sole that was taken in anew is two corrections away from there, if one was without slip.
        time = self.period * (2.0 if record["still"][0] == 1 else 1.0)
        velocity = moved[way.argmin(), 0] / time  # of the slowest sole
        speed = float(np.linalg.norm(velocity))
        has_stood = bool((record["stood"][0][held == 1] >= _STOOD).any())
        if speed <= self._noise.jump or (has_stood and record["onset"][0] == 0):
            record["onset"] = max(record["onset"][0] - 1, 0)
            record["slip_velocity"] = 0.0
            return False
        before = record["slip_velocity"][0]
        same = np.linalg.norm(velocity - before) < _SAME
        fading = speed < _FADING * np.linalg.norm(before)
        record["lasting"] = record["lasting"] + 1 if same else 0
        record["slip_velocity"] = velocity
        # A sole that turns about its edge moves by as much as that; one alone may as well have been
        # hit, or drag. One that slides when it lands is slower at each correction.
        alone = len(way) == 1
        beyond_turn = bool((way >= (_LEVER_ALONE if alone else _LEVER) * turn).all())
        if alone and (fading or not beyond_turn):
            return False
        if not has_stood and record["lasting"][0] < _SLIDES:
            return False
        P = self.P.copy()
        self._doubt_velocity(speed, time)
        if record["lasting"][0] >= _LASTING and beyond_turn:
            self._doubt_soles()
        if kernels.correct(record, held, h, F) < 0:
            return True
        record["P"] = P
        return False

    @property
    def period(self) -> float:
        """Time between the last two corrections, s."""
        return float(self.record["elapsed"][0])

    def _doubt_soles(self) -> None:
        """Take it for unknown how the soles are turned."""
        P, feet = self.P, self.F.shape[0]
        turns = layout.FOOT_POSITION + 3 * feet + np.arange(3 * feet)
        P[turns, turns] += _TURNED**2

    def _doubt_velocity(self, speed: float, time: float) -> None:
        """Add a jump of the velocity by about `speed`, a time ago (s), to the covariance."""
        P = self.P
        velocity = np.arange(layout.VELOCITY, layout.POSITION)
        position = velocity + 3
        for rows, columns, factor in (
            (velocity, velocity, 1.0),
            (velocity, position, time),
            (position, velocity, time),
            (position, position, time * time),
        ):
            P[rows, columns] += factor * speed * speed
