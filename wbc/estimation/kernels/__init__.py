"""Compiled parts of the estimator.

Without Numba the same source runs as plain Python, on numpy where that is much faster.
"""

from wbc.jit.loading import load_kernels

# Here, so that a first import that compiles says so.
load_kernels(
    *(
        f"wbc.estimation.kernels.{name}"
        for name in ("inekf", "legs", "loads", "prediction", "wrenches")
    )
)
