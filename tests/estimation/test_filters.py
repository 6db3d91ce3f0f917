"""The estimator's building blocks against plain formulas."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from wbc.estimation import EstimatorNoise
from wbc.estimation.inekf import InvariantFilter
from wbc.estimation.joints import JointFilter, stationary_gain
from wbc.estimation.kernels.legs import LINK, poses_type
from wbc.estimation.kernels.loads import LOAD_LIMITS, read_load
from wbc.estimation.kernels.moving_soles import tip
from wbc.estimation.kernels.prediction import predict


def period(
    f: InvariantFilter,
    slip: tuple[float, ...],
    joints: tuple[np.ndarray, ...],
    imu: tuple[np.ndarray, ...],
) -> None:
    """One period of a robot without legs: the sole centres are at the IMU."""
    update, state, acceleration, position, velocity = joints
    chains = (np.zeros(3, LINK), np.array([1, 2, 3]), np.zeros(1, poses_type(2)))
    chains[0]["joint"] = -1
    result = (np.zeros(7 + position.size), np.zeros(6 + position.size))
    filters = (f.record, np.array(slip), state, *chains, update)
    predict(*filters, *result, acceleration, position, velocity, *imu)


def propagate(
    f: InvariantFilter, gyro: np.ndarray, accelerometer: np.ndarray, slip: tuple[float, ...]
) -> None:
    none = np.zeros(0)
    joints = (np.zeros((2, 5)), np.zeros((2, 0)), none, none, none)
    period(f, slip, joints, (gyro, accelerometer))


def read(f: JointFilter, reading: np.ndarray, acceleration: np.ndarray | None = None) -> None:
    """One reading of position and velocity of a single joint."""
    imu = InvariantFilter(0.002, np.zeros(3), EstimatorNoise(), [np.eye(6)] * 2)
    foreseen = np.zeros(1) if acceleration is None else acceleration
    update = f.update_matrix(acceleration is not None)
    joints = (update, f.state, foreseen, reading[:1], reading[1:])
    period(imu, (0.0, 0.0), joints, (np.zeros(3), np.zeros(3)))
    f.fresh = False


def filled(seed: int = 0, turn: float = 1e-3) -> tuple[InvariantFilter, np.ndarray, np.ndarray]:
    """A filter that stands on two feet, with a covariance of a few hundred steps.

    Args:
        seed: of the IMU's readings.
        turn: standard deviation of how the legs see a sole turned, rad.
    """
    random = np.random.default_rng(seed)
    noise = EstimatorNoise()
    covariance = np.diag([1e-6] * 3 + [turn**2] * 3)
    f = InvariantFilter(0.002, np.array([0.0, 0.0, -9.81]), noise, [covariance] * 2)
    f.reset(pin.rpy.rpyToMatrix(0.1, -0.2, 0.7), np.array([0.3, -0.1, 0.05]), np.zeros(3))
    h = np.array([[0.1, 0.1, -0.9], [0.0, -0.1, -0.85]])
    F = np.array([pin.rpy.rpyToMatrix(0.05, 0.1, 0.0), np.eye(3)])
    for foot in range(2):
        f.land(foot, h[foot], F[foot])
    for _ in range(200):
        propagate(f, random.normal(0.1, 0.3, 3), random.normal(0.0, 1.0, 3), (1.0, 1.0))
    return f, h, F


def test_touchdown_places_the_foot_by_forward_kinematics():
    f, h, F = filled()
    f.land(1, h[1], F[1])
    np.testing.assert_allclose(f.vectors[3], f.p + f.R @ h[1], atol=1e-12)
    np.testing.assert_allclose(f.F[1], f.R @ F[1], atol=1e-12)
    # Just landed, foot and IMU differ by the legs' noise alone.
    place, turn = slice(12, 15), slice(18, 21)
    H = np.zeros((6, 27))
    H[:3, 6:9], H[:3, place] = np.eye(3), -np.eye(3)
    H[3:, :3], H[3:, turn] = np.eye(3), -np.eye(3)
    np.testing.assert_allclose(H @ f.P @ H.T, 1e-6 * np.eye(6), atol=1e-12)


@pytest.mark.parametrize("feet", [(0,), (1,), (0, 1)])
def test_correction_equals_the_textbook_kalman_update(feet):
    f, _, _ = filled()
    random = np.random.default_rng(1)
    rows = list(feet)
    xi = 1e-5 * random.standard_normal(3)
    F = np.array([f.R.T @ pin.exp3(xi) @ f.F[i] for i in rows])
    off = 1e-4 * random.standard_normal((len(rows), 3))
    h = np.array([f.R.T @ (f.vectors[2 + i] - f.p + o) for i, o in zip(rows, off, strict=True)])
    H = np.zeros((6 * len(rows), 27))
    r = np.zeros(6 * len(rows))
    for k, i in enumerate(rows):
        H[6 * k : 6 * k + 3, 6:9] = H[6 * k + 3 : 6 * k + 6, 0:3] = np.eye(3)
        H[6 * k : 6 * k + 3, 9 + 3 * i : 12 + 3 * i] = -np.eye(3)
        H[6 * k + 3 : 6 * k + 6, 15 + 3 * i : 18 + 3 * i] = -np.eye(3)
        r[6 * k : 6 * k + 3] = off[k]
        r[6 * k + 3 : 6 * k + 6] = xi
    P = f.P.copy()
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + 1e-6 * np.eye(len(r)))
    step = -K @ r
    expected_P = (np.eye(27) - K @ H) @ P
    bias, v, R, places = f.gyro_bias.copy(), f.v.copy(), f.R.copy(), f.vectors[1:].copy()
    positions, rotations = np.zeros((2, 3)), np.zeros((2, 3, 3))
    positions[rows], rotations[rows] = h, F
    f.correct(np.array([foot in feet for foot in range(2)], dtype=np.int64), positions, rotations)
    turn, left = pin.exp3(step[:3]), pin.Jexp3(-step[:3])
    np.testing.assert_allclose(f.gyro_bias - bias, step[21:24], atol=1e-9)
    np.testing.assert_allclose(f.R, turn @ R, atol=1e-10)
    np.testing.assert_allclose(f.v, turn @ v + left @ step[3:6], atol=1e-10)
    # Places are the textbook's, all moved by the same way: that of the soles that stand is undone.
    textbook = places @ turn.T + step[6:15].reshape(3, 3) @ left.T
    standing = [1 + i for i in rows]
    way = np.mean(places[standing] - textbook[standing], axis=0)
    np.testing.assert_allclose(f.vectors[1:], textbook + way, atol=1e-10)
    T = np.eye(27)
    for place in range(6, 15, 3):  # δx − ξ_R × x of a place x + way
        T[place : place + 3, :3] = pin.skew(way)
    np.testing.assert_allclose(f.P, T @ expected_P @ T.T, atol=1e-12)
    assert np.abs(way).max() > 1e-5, "the textbook's soles move"


def test_errors_propagate_as_the_linear_model_says():
    """Two filters that differ by a small error: its change is the transition matrix's."""
    random = np.random.default_rng(2)
    gyro, force = np.array([0.4, -0.3, 0.8]), np.array([0.5, -1.0, 9.0])
    xi = 1e-6 * random.standard_normal(27)

    def disturbed(by: np.ndarray) -> InvariantFilter:
        """exp(ξ) times the filled filter, to first order in the translations."""
        f, _, _ = filled()
        rotation, moves = pin.exp3(by[:3]), by[3:15].reshape(4, 3)
        f.R[:] = rotation @ f.R
        f.vectors[:] = f.vectors @ rotation.T + moves @ pin.Jexp3(-by[:3]).T
        for F, turn in zip(f.F, by[15:21].reshape(2, 3), strict=True):
            F[:] = pin.exp3(turn) @ F
        f.gyro_bias[:] += by[21:24]
        f.accelerometer_bias[:] += by[24:]
        return f

    def error(a: InvariantFilter, b: InvariantFilter) -> np.ndarray:
        """ξ with a = exp(ξ) b, to first order."""
        turn = pin.log3(a.R @ b.R.T)
        moved = a.vectors - b.vectors - np.cross(turn, b.vectors)
        feet = [pin.log3(x @ y.T) for x, y in zip(a.F, b.F, strict=True)]
        return np.concatenate(
            [
                turn,
                moved.ravel(),
                *feet,
                a.gyro_bias - b.gyro_bias,
                a.accelerometer_bias - b.accelerometer_bias,
            ]
        )

    a, b = disturbed(xi), disturbed(np.zeros(27))
    before = error(a, b)
    np.testing.assert_allclose(before, xi, atol=1e-10)
    for f in (a, b):
        propagate(f, gyro, force, (1.0, 1.0))
    after = error(a, b)
    transition = b.record["transition"][0]
    # First order in the period: what is left is of the size of dt².
    np.testing.assert_allclose(after, transition @ before, atol=3e-11)
    assert np.abs(after - before).max() > 3e-9, "the step changes the error"


def test_foot_in_the_air_keeps_the_covariance_of_the_other_foot():
    f, _, _ = filled()
    noise = f.P[9:12, 9:12].copy()
    propagate(f, np.zeros(3), np.array([0.0, 0.0, 9.81]), (0.0, 5.0))
    grown = f.P[12:15, 12:15].trace()
    assert f.P[9:12, 9:12].trace() < noise.trace() + 1e-6
    assert grown > 0.0


def test_joint_filter_reduces_noise_and_follows_the_motion():
    random = np.random.default_rng(3)
    dt, n = 0.002, 3000
    time = dt * np.arange(n)
    q, v = 0.1 * np.sin(6.0 * time), 0.6 * np.cos(6.0 * time)
    a = -3.6 * np.sin(6.0 * time)
    noisy_q = q + 1e-3 * random.standard_normal(n)
    noisy_v = v + 0.05 * random.standard_normal(n)

    def errors(acceleration: float, foreseen: bool) -> tuple[float, float]:
        f = JointFilter(1, dt, 1e-3, 0.05, acceleration, acceleration)
        out = []
        for k in range(n):
            known = np.array([a[k]]) if foreseen else None
            read(f, np.array([noisy_q[k], noisy_v[k]]), known)
            out.append((f.state[0, 0] - q[k], f.state[1, 0] - v[k]))
        deviation = np.std(np.array(out)[100:], axis=0)
        return float(deviation[0]), float(deviation[1])

    plain, helped = errors(10.0, False), errors(5.0, True)
    assert plain[0] < 0.6e-3
    assert plain[1] < 0.028
    assert helped[1] < 0.7 * plain[1]
    assert errors(np.inf, False)[1] == pytest.approx(0.05, rel=0.05)


@pytest.mark.parametrize("foreseen", [None, 3.0])
def test_joint_filter_predicts_and_then_corrects(foreseen):
    dt, sigma, surprise = 0.002, 20.0, 6.0
    f = JointFilter(1, dt, 1e-3, 0.05, sigma, surprise)
    read(f, np.array([0.3, -0.2]))
    q, v = f.state[:, 0]
    assert (q, v) == (0.3, -0.2)
    known = None if foreseen is None else np.array([foreseen])
    K = stationary_gain(dt, 1e-3, 0.05, sigma if foreseen is None else surprise)
    for reading in ([0.31, -0.1], [0.28, 0.3]):
        v += dt * (foreseen or 0.0)
        q += dt * v
        q, v = np.array([q, v]) + K @ (np.array(reading) - [q, v])
        read(f, np.array(reading), known)
        np.testing.assert_allclose(f.state[:, 0], [q, v], rtol=1e-12)


def tipped(f: InvariantFilter, h: np.ndarray, F: np.ndarray, angle: float, pivot: np.ndarray):
    """Where legs and sole are seen after the first sole has tipped about a point of its own."""
    R = pin.rpy.rpyToMatrix(0.0, angle, 0.0)
    sole, turned = f.R @ F[0], f.R @ F[0] @ R
    place = f.R @ h[0] + sole @ pivot - turned @ pivot
    seen_h, seen_F = h.copy(), F.copy()
    seen_h[0], seen_F[0] = f.R.T @ place, f.R.T @ turned
    return seen_h, seen_F


def test_sole_that_tips_about_its_pressure_is_no_slip_and_moves_no_base():
    angle, pivot = 0.03, np.array([0.1, 0.0, 0.0])
    held = np.array([1, 0])
    for told in (True, False):
        f, h, F = filled()
        f.correct(held, h, F)
        velocity, corrections = f.v.copy(), int(f.record["corrections"][0])
        if told:
            tip(f.record, 0, *pivot[:2], 0.0, 0.05**2)
        f.correct(held, *tipped(f, h, F, angle, pivot))
        assert (int(f.record["corrections"][0]) > corrections) == told  # else: taken in anew
        np.testing.assert_allclose(f.v, velocity, atol=0.02)
        assert np.linalg.eigvalsh(f.P).min() > -1e-12


@pytest.mark.parametrize(
    ("speeds", "turns", "found"),  # m/s; rad per m
    [
        ((3.0, 3.0), (0.0, 0.0), True),  # the robot was moved
        ((1.5, 3.0), (0.0, 0.0), True),  # the same in the middle of the first period
        ((9.0, 5.0), (8.0, 0.0), False),  # a sole that lands and slides to a stop
        ((3.0, 3.0), (5.0, 5.0), False),  # one that turns nearly by as much as it moves
    ],
)
def test_a_sole_alone_tells_of_a_shock_only_if_it_goes_on_moving_without_turning(
    speeds, turns, found
):
    f, h, F = filled(turn=0.03)
    held = np.array([1, 0])
    for _ in range(3):
        f.correct(held, h, F)
    velocity = f.v.copy()
    seen_h, seen_F = h.copy(), F.copy()
    for speed, turn in zip(speeds, turns, strict=True):
        way = speed * f.period
        seen_h[0] -= f.R.T @ np.array([way, 0.0, 0.0])
        seen_F[0] = pin.rpy.rpyToMatrix(0.0, 0.0, turn * way) @ seen_F[0]
        f.correct(held, seen_h, seen_F)
    change = np.linalg.norm(f.v - velocity)
    assert change > 1.5 if found else change < 0.2


@pytest.mark.parametrize(
    ("speeds", "found"),  # m/s
    [
        ([3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.0, 0.0], False),  # it slides to a stop
        ([3.0] * 8, True),  # nothing slides at the same speed: the robot's velocity was not known
    ],
)
def test_a_sole_that_moves_since_it_landed_tells_of_a_shock_only_if_its_velocity_stays(
    speeds, found
):
    f, h, F = filled(turn=0.03)
    for _ in range(3):  # the other foot stands, and leaves the ground as this one lands
        f.correct(np.array([0, 1]), h, F)
    f.land(0, h[0], F[0])
    velocity, seen_h = f.v.copy(), h.copy()
    for speed in speeds:
        seen_h[0] -= f.R.T @ np.array([speed * f.period, 0.0, 0.0])
        f.correct(np.array([1, 0]), seen_h, F)
    change = np.linalg.norm(f.v - velocity)
    assert change > 2.5 if found else change < 0.2


def test_stationary_gain_is_a_fixed_point_of_the_riccati_equation():
    dt, s, w, a = 0.002, 1e-3, 0.05, 12.0
    K = stationary_gain(dt, s, w, a)
    A = np.array([[1.0, dt], [0.0, 1.0]])
    kick = a * np.array([0.5 * dt * dt, dt])
    N = np.diag([s * s, w * w])
    # K = P (P + N)^-1  gives  P = (1 - K)^-1 K N.
    P = np.linalg.solve(np.eye(2) - K, K @ N)
    after = P - K @ P
    np.testing.assert_allclose(A @ after @ A.T + np.outer(kick, kick), P, rtol=1e-6)


def test_a_sole_that_stands_is_trusted_less_the_less_it_carries():
    limits = np.array([(0.1, 0.05, 0.4, 600.0)], dtype=LOAD_LIMITS)
    slip, factors = np.zeros(2), []
    for share in (0.8, 0.4, 0.2, 0.05, 0.0):
        wrench = np.array([1.0, -2.0, 600.0 * share, 0.3, 0.2, 0.1])
        load, _ = read_load(wrench, limits, True, slip, 1)
        assert load == pytest.approx(share)
        factors.append(float(slip[1]))
    assert factors[0] == factors[1] == 1.0
    assert factors == sorted(factors)
    assert factors[2] == pytest.approx(2.0)
    assert np.isfinite(factors[-1])
    assert slip[0] == 0.0
    read_load(np.array([0.0, 0.0, 300.0, 0.0, 0.0, 0.0]), limits, False, slip, 1)
    assert slip[1] == 0.0  # it was in the air


def test_contact_begins_and_ends_at_loads_of_their_own():
    limits = np.array([(0.1, 0.05, 0.4, 600.0)], dtype=LOAD_LIMITS)
    slip, stands, decisions = np.zeros(1), False, []
    for share in (0.04, 0.07, 0.11, 0.07, 0.04):
        wrench = np.array([0.0, 0.0, 600.0 * share, 0.0, 0.0, 0.0])
        _, stands = read_load(wrench, limits, stands, slip, 0)
        decisions.append(stands)
    assert decisions == [False, False, True, True, False]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("entry", range(6))
def test_a_wrench_with_an_entry_that_is_not_finite_has_no_load(bad, entry):
    limits = np.array([(0.1, 0.05, 0.4, 600.0)], dtype=LOAD_LIMITS)
    wrench = np.zeros(6)
    wrench[entry] = bad
    assert np.isnan(read_load(wrench, limits, True, np.zeros(1), 0)[0])
