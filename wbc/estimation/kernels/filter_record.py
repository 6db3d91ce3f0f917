"""The invariant filter as one record: its state, what is constant, and workspace."""

from __future__ import annotations

import numpy as np

FEET = 2
#: Size of the error `[ξ_R, ξ_v, ξ_p, ξ_d…, ξ_F…, b_g, b_a]`, and where its parts begin.
SIZE = 15 + 6 * FEET
VELOCITY, POSITION, FOOT_POSITION, FOOT_ROTATION = 3, 6, 9, 9 + 3 * FEET
GYRO_BIAS, ACCELEROMETER_BIAS = SIZE - 6, SIZE - 3
#: Rows that a gyro error moves: rotation and vectors.
MOVED = 9 + 3 * FEET
_ROWS = 6 * FEET

FILTER = np.dtype(
    [
        # State.
        ("R", float, (3, 3)),
        ("vectors", float, (2 + FEET, 3)),
        ("F", float, (FEET, 3, 3)),
        ("gyro_bias", float, (3,)),
        ("accelerometer_bias", float, (3,)),
        ("P", float, (SIZE, SIZE)),
        (
            "drift_factor",
            float,
            (FEET,),
        ),  # sum of squared slip factors since the last covariance step
        ("pending", np.int64),  # periods since then
        ("started", np.int64),  # whether there is a reading of the gyro since the reset
        ("gyro", float, (3,)),  # the last one, IMU axes, rad/s
        ("corrections", np.int64),
        # Constants.
        ("origin", float, (3,)),  # where positions count from, world axes, m
        ("dt", float),  # s
        ("every", np.int64),  # periods between two corrections
        ("gravity", float, (3,)),  # m/s²
        ("gyro_step", float),  # variance that a period's gyro noise adds, rad²
        ("process", float, (SIZE,)),  # diagonal that a period adds
        ("foot_drift", float, (SIZE, FEET)),  # the same by a sole that stands
        ("leg_noise", float, (FEET, 6, 6)),  # of a sole's pose as the encoders see it, IMU axes
        ("slip_gate", float),  # χ² of six readings
        # Workspace.
        ("transition", float, (SIZE, SIZE)),
        ("product", float, (SIZE, SIZE)),
        ("lever", float, (MOVED, 3)),
        ("HP", float, (_ROWS, SIZE)),
        ("Y", float, (_ROWS, SIZE)),
        ("S", float, (_ROWS, _ROWS)),
        ("inverse", float, (_ROWS, _ROWS)),  # of S's Cholesky factor
        ("residual", float, (_ROWS,)),
        ("whitened", float, (_ROWS,)),
        ("weighted", float, (_ROWS,)),
        ("xi", float, (SIZE,)),
        ("noise", float, (6, 6)),
        ("A", float, (3, 3)),
        ("B", float, (3, 3)),
        ("C", float, (3, 3)),
        ("a", float, (3,)),
        ("b", float, (3,)),
    ],
    align=True,
)
