"""The invariant filter's steps; see `wbc.estimation.inekf` for the equations."""

from __future__ import annotations

import numpy as np

from wbc.estimation.kernels.filter_record import (
    ACCELEROMETER_BIAS,
    FEET,
    FOOT_POSITION,
    GYRO_BIAS,
    POSITION,
    VELOCITY,
    filter_type,
)
from wbc.estimation.kernels.matrix import (
    add,
    add_gram,
    combine_rows,
    conjugate,
    difference,
    difference_of_columns,
    invert_factor,
    move_errors,
    subtract,
    whiten,
)
from wbc.estimation.kernels.rotation import copy, exponential, left_jacobian, multiply, rotate, skew
from wbc.jit.compile import argument_types, kernel, subkernel

#: Corrections between two rounds of `_remove_rounding`.
_TIDY = 20

_VECTOR = np.zeros(3)


@subkernel
def _set_transition(f: np.ndarray, time: float) -> None:
    """The errors' transition matrix over a time, and the lever of gyro errors [1; x ×]."""
    Phi, lever, R, vectors, axes = f["transition"], f["lever"], f["R"], f["vectors"], f["A"]
    skew(f["gravity"], axes)
    for i in range(Phi.shape[0]):
        Phi[i, i] = 1.0
    for i in range(3):
        Phi[POSITION + i, VELOCITY + i] = time
        for j in range(3):
            Phi[VELOCITY + i, j] = time * axes[i, j]
            Phi[POSITION + i, j] = 0.5 * time * time * axes[i, j]
            Phi[VELOCITY + i, ACCELEROMETER_BIAS + j] = -time * R[i, j]
            lever[i, j] = 1.0 if i == j else 0.0
    for n in range(vectors.shape[0]):
        skew(vectors[n], lever[3 + 3 * n : 6 + 3 * n])
    for i in range(lever.shape[0]):
        for j in range(3):
            Phi[i, GYRO_BIAS + j] = -time * (
                lever[i, 0] * R[0, j] + lever[i, 1] * R[1, j] + lever[i, 2] * R[2, j]
            )


@subkernel
def propagate_covariance(f: np.ndarray) -> None:
    """Propagate the covariance over the periods since it was last."""
    count = f["pending"]
    if count == 0:
        return
    f["pending"] = 0
    time = f["elapsed"] = count * f["dt"]
    P, Phi, product, lever = f["P"], f["transition"], f["product"], f["lever"]
    _set_transition(f, time)
    np.dot(Phi, P, product)
    np.dot(product, Phi.T, P)
    gyro = count * f["gyro_step"]
    add_gram(P, gyro, lever)
    process, foot_drift, drift_factor = f["process"], f["foot_drift"], f["drift_factor"]
    for i in range(P.shape[0]):
        P[i, i] += count * process[i]
        for foot in range(drift_factor.size):
            P[i, i] += foot_drift[i, foot] * drift_factor[foot]
    for foot in range(drift_factor.size):
        drift_factor[foot] = 0.0


@subkernel
def _leg_noise_in_world(f: np.ndarray, foot: int) -> None:
    """The legs' noise of a sole's pose in world axes: N = R C Rᵀ block by block."""
    R, C, N, work = f["R"], f["leg_noise"][foot], f["noise"], f["A"]
    for i in range(0, 6, 3):
        for j in range(0, 6, 3):
            conjugate(R, C[i : i + 3, j : j + 3], N[i : i + 3, j : j + 3], work)


@subkernel
def _land(f: np.ndarray, foot: int, h: np.ndarray, F: np.ndarray) -> None:
    propagate_covariance(f)
    P, R, vectors, place = f["P"], f["R"], f["vectors"], f["a"]
    rotate(R, h, place)
    for i in range(3):
        vectors[2 + foot, i] = vectors[1, i] + place[i]
    multiply(R, F, f["F"][foot])
    rotation = FOOT_POSITION + 3 * f["F"].shape[0]
    for part in range(2):
        own = (FOOT_POSITION if part == 0 else rotation) + 3 * foot
        source = POSITION if part == 0 else 0
        for i in range(3):
            for j in range(P.shape[0]):
                P[own + i, j] = P[source + i, j]
        for i in range(3):
            for j in range(P.shape[0]):
                P[j, own + i] = P[j, source + i]
    _leg_noise_in_world(f, foot)
    for i in range(6):
        for j in range(6):
            row = FOOT_POSITION + 3 * foot + i if i < 3 else rotation + 3 * foot + i - 3
            column = FOOT_POSITION + 3 * foot + j if j < 3 else rotation + 3 * foot + j - 3
            P[row, column] += f["noise"][i, j]


@subkernel
def find_offset(f: np.ndarray, foot: int, h: np.ndarray, out: np.ndarray) -> None:
    """How far a sole is off the place where it stands, `out = p + R h − d`."""
    place, vectors = f["a"], f["vectors"]
    rotate(f["R"], h, place)
    for i in range(3):
        out[i] = vectors[1, i] + place[i] - vectors[2 + foot, i]


@subkernel
def _innovate(f: np.ndarray, foot: int, row: int, h: np.ndarray, F: np.ndarray) -> None:
    """Six rows of H P and of the residual: where a sole is off, and how it is turned."""
    P, HP, residual, R = f["P"], f["HP"], f["residual"], f["R"]
    seen, off = f["A"], f["B"]
    rotation = FOOT_POSITION + 3 * f["F"].shape[0]
    difference(P, POSITION, FOOT_POSITION + 3 * foot, HP[row : row + 3])
    difference(P, 0, rotation + 3 * foot, HP[row + 3 : row + 6])
    find_offset(f, foot, h, residual[row : row + 3])
    multiply(R, F, seen)
    for i in range(3):
        for j in range(3):
            s = 0.0
            for k in range(3):
                s += seen[i, k] * f["F"][foot, j, k]
            off[i, j] = s
    # Of R F F̂ᵀ, a rotation by milliradians, sine and angle are the same.
    residual[row + 3] = 0.5 * (off[2, 1] - off[1, 2])
    residual[row + 4] = 0.5 * (off[0, 2] - off[2, 0])
    residual[row + 5] = 0.5 * (off[1, 0] - off[0, 1])


@subkernel
def _retract(f: np.ndarray) -> None:
    # Γ₀ and Γ₁ of the group of double direct isometries: exp(a) and ∫₀¹ exp(s a) ds.
    xi, turn, left, turned, a, b = f["xi"], f["A"], f["B"], f["C"], f["a"], f["b"]
    exponential(xi[:3], turn)
    left_jacobian(xi[:3], left)
    multiply(turn, f["R"], turned)
    copy(turned, f["R"])
    feet = f["F"].shape[0]
    rotation = FOOT_POSITION + 3 * feet
    for n in range(2 + feet):
        x = f["vectors"][n]
        rotate(turn, x, a)
        rotate(left, xi[3 + 3 * n : 6 + 3 * n], b)
        for i in range(3):
            x[i] = a[i] + b[i]
    for foot in range(feet):
        exponential(xi[rotation + 3 * foot : rotation + 3 * foot + 3], turn)
        multiply(turn, f["F"][foot], turned)
        copy(turned, f["F"][foot])
    for i in range(3):
        f["gyro_bias"][i] += xi[GYRO_BIAS + i]
        f["accelerometer_bias"][i] += xi[ACCELEROMETER_BIAS + i]


@subkernel
def _add_places(f: np.ndarray, held: np.ndarray, factor: float, way: np.ndarray) -> None:
    """Add a multiple of the sum of the places of the soles that stand to `way`."""
    for foot in range(held.size):
        if held[foot]:
            for i in range(3):
                way[i] += factor * f["vectors"][2 + foot, i]


@subkernel
def _move_world(f: np.ndarray, way: np.ndarray) -> None:
    """Move all places by `way`, m, about which nothing is known: what is seen stays the same."""
    vectors = f["vectors"]
    for n in range(1, vectors.shape[0]):
        for i in range(3):
            vectors[n, i] += way[i]
    move_errors(f["P"], way, POSITION, FOOT_POSITION + 3 * f["F"].shape[0])


@subkernel
def _orthogonalise(f: np.ndarray, R: np.ndarray) -> None:
    """`R ← 1.5 R − 0.5 R Rᵀ R`."""
    square, cube = f["A"], f["B"]
    for i in range(3):
        for j in range(3):
            square[i, j] = R[0, i] * R[0, j] + R[1, i] * R[1, j] + R[2, i] * R[2, j]
    multiply(R, square, cube)
    for i in range(3):
        for j in range(3):
            R[i, j] = 1.5 * R[i, j] - 0.5 * cube[i, j]


@subkernel
def _remove_rounding(f: np.ndarray) -> None:
    """Keep P symmetric, and R and F rotations, by one Newton step of the polar decomposition."""
    P = f["P"]
    for i in range(P.shape[0]):
        for j in range(i):
            P[i, j] = P[j, i] = 0.5 * (P[i, j] + P[j, i])
    _orthogonalise(f, f["R"])
    for foot in range(f["F"].shape[0]):
        _orthogonalise(f, f["F"][foot])


@subkernel
def propagate(f: np.ndarray, gyro: np.ndarray, accelerometer: np.ndarray, slip: np.ndarray) -> bool:
    """Advance by one period; return whether a correction is due.

    Args:
        f: the filter.
        gyro: (3,) at the end of the period, IMU axes, rad/s; the mean with the one before counts.
            The first one after a reset belongs to the reset's instant: nothing advances.
        accelerometer: (3,) mean specific force over the period, IMU axes, m/s².
        slip: (feet,) a factor on its drift; 0 for a foot in the air.
    """
    dt, R, vectors, last = f["dt"], f["R"], f["vectors"], f["gyro"]
    half, middle, a, force = f["A"], f["B"], f["a"], f["b"]
    for i in range(3):
        mean = 0.5 * (gyro[i] + last[i])
        last[i] = gyro[i]
        a[i] = 0.5 * dt * (mean - f["gyro_bias"][i])
        force[i] = accelerometer[i] - f["accelerometer_bias"][i]
    if not f["started"]:
        f["started"] = 1
        return False
    exponential(a, half)
    multiply(R, half, middle)
    rotate(middle, force, a)
    for i in range(3):
        a[i] += f["gravity"][i]
        vectors[1, i] += dt * vectors[0, i] + 0.5 * dt * dt * a[i]
        vectors[0, i] += dt * a[i]
    multiply(middle, half, R)
    f["pending"] += 1
    for i in range(f["F"].shape[0]):
        f["drift_factor"][i] += slip[i] * slip[i]
    return bool(f["pending"] >= f["every"])


@kernel(*(argument_types(np.zeros(1, filter_type(n)), 0, _VECTOR, np.zeros((3, 3))) for n in FEET))
def land(filter_: np.ndarray, foot: int, h: np.ndarray, F: np.ndarray) -> None:
    """Take a sole as standing where the legs see it now.

    Args:
        filter_: (1,) the filter.
        foot: its index.
        h: (3,) sole centre in IMU axes, m.
        F: (3, 3) sole axes to IMU axes.
    """
    _land(filter_[0], foot, h, F)


@kernel(
    *(
        argument_types(
            np.zeros(1, filter_type(n)),
            np.zeros(n, np.int64),
            np.zeros((n, 3)),
            np.zeros((n, 3, 3)),
        )
        for n in FEET
    )
)
def correct(filter_: np.ndarray, held: np.ndarray, h: np.ndarray, F: np.ndarray) -> int:
    """Correct by soles that stand still, as the legs see them.

    Innovations too large to be noise mean that a sole has slipped: then nothing is corrected.

    Args:
        filter_: (1,) the filter.
        held: (feet,) 1 for a sole that stands still, else 0.
        h: (feet, 3) sole centres in IMU axes, m.
        F: (feet, 3, 3) sole axes to IMU axes.

    Returns:
        The index of the sole that has slipped most likely, or −1.
    """
    f = filter_[0]
    P, HP, S, residual, xi = f["P"], f["HP"], f["S"], f["residual"], f["xi"]
    feet, rotation = held.size, FOOT_POSITION + 3 * held.size
    m = 0
    subtract(HP, HP)
    for foot in range(feet):
        if held[foot]:
            _innovate(f, foot, m, h[foot], F[foot])
            m += 6
    if m == 0:
        return -1
    k = 0
    for foot in range(feet):
        if held[foot]:
            _leg_noise_in_world(f, foot)
            difference_of_columns(HP, POSITION, FOOT_POSITION + 3 * foot, S[:, k : k + 3])
            difference_of_columns(HP, 0, rotation + 3 * foot, S[:, k + 3 : k + 6])
            add(S[k : k + 6, k : k + 6], f["noise"])
            k += 6
    invert_factor(S, f["inverse"], m)
    whitened, weighted = f["whitened"], f["weighted"]
    whiten(f["inverse"], residual, whitened, weighted)
    slipped, largest, k = -1, f["slip_gate"], 0
    for foot in range(feet):
        if held[foot]:
            s = 0.0
            for i in range(k, k + 6):
                s += residual[i] * weighted[i]
            if s > largest:
                slipped, largest = foot, s
            k += 6
    if slipped >= 0:
        return slipped
    combine_rows(weighted, HP, xi)
    way = f["way"]
    way[0] = way[1] = way[2] = 0.0
    _add_places(f, held, 6.0 / m, way)
    _retract(f)
    _add_places(f, held, -6.0 / m, way)
    np.dot(f["inverse"], HP, f["Y"])
    np.dot(f["Y"].T, f["Y"], f["product"])
    subtract(P, f["product"])
    _move_world(f, way)
    f["corrections"] += 1
    if f["corrections"] % _TIDY == 0:
        _remove_rounding(f)
    return -1
