"""The invariant filter as one record: its state, what is constant, and workspace."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

#: Numbers of feet for which the kernels are compiled.
FEET = (2, 4)
#: Where the parts of the error `[ξ_R, ξ_v, ξ_p, ξ_d…, ξ_F…, b_g, b_a]` begin: ξ_F after three
#: entries for each foot, and the biases, which are at its end, counted from there.
VELOCITY, POSITION, FOOT_POSITION = 3, 6, 9
GYRO_BIAS, ACCELEROMETER_BIAS = -6, -3


@lru_cache
def filter_type(feet: int) -> np.dtype:
    """Return the type of the record of a filter with so many feet."""
    size, rows = 15 + 6 * feet, 6 * feet
    return np.dtype(
        [
            # State.
            ("R", float, (3, 3)),
            ("vectors", float, (2 + feet, 3)),
            ("F", float, (feet, 3, 3)),
            ("gyro_bias", float, (3,)),
            ("accelerometer_bias", float, (3,)),
            ("P", float, (size, size)),
            ("drift_factor", float, (feet,)),  # sum of squared slip factors since its last step
            ("pending", np.int64),  # periods since then
            ("elapsed", float),  # time over which that step went, s
            ("started", np.int64),  # whether there is a reading of the gyro since the reset
            ("gyro", float, (3,)),  # the last one, IMU axes, rad/s
            ("corrections", np.int64),
            ("onset", np.int64),  # corrections left in which slipping soles may be a shock
            ("slip_velocity", float, (3,)),  # theirs at the last one, m/s; 0 if it was no shock
            ("lasting", np.int64),  # corrections for which it has been the same
            ("still", np.int64),  # corrections since then
            ("stood", np.int64, (feet,)),  # corrections without a slip since a sole landed
            # Constants.
            ("origin", float, (3,)),  # where positions count from, world axes, m
            ("dt", float),  # s
            ("every", np.int64),  # periods between two corrections
            ("early", np.int64),  # the same while a sole seems to move
            ("moved", float),  # distance from which on it does, m
            ("gravity", float, (3,)),  # m/s²
            ("gyro_step", float),  # variance that a period's gyro noise adds, rad²
            ("process", float, (size,)),  # diagonal that a period adds
            ("foot_drift", float, (size, feet)),  # the same by a sole that stands
            ("leg_noise", float, (feet, 6, 6)),  # of a sole's pose as the encoders see it, IMU axes
            ("slip_gate", float),  # χ² of six readings
            # Workspace.
            ("transition", float, (size, size)),
            ("product", float, (size, size)),
            ("lever", float, (9 + 3 * feet, 3)),  # of the rows that a gyro error moves
            ("HP", float, (rows, size)),
            ("Y", float, (rows, size)),
            ("S", float, (rows, rows)),
            ("inverse", float, (rows, rows)),  # of S's Cholesky factor
            ("residual", float, (rows,)),
            ("whitened", float, (rows,)),
            ("weighted", float, (rows,)),
            ("xi", float, (size,)),
            ("noise", float, (6, 6)),
            ("A", float, (3, 3)),
            ("B", float, (3, 3)),
            ("C", float, (3, 3)),
            ("a", float, (3,)),
            ("b", float, (3,)),
            ("way", float, (3,)),
        ],
        align=True,
    )
