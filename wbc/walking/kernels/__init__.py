"""Compiled parts of walking.

Without Numba the same source runs as plain Python.
"""

from wbc.jit.loading import load_kernels

# Here, so that a first import that compiles says so.
load_kernels(
    "wbc.walking.kernels.ground",
    "wbc.walking.kernels.swing_momentum",
    "wbc.walking.kernels.trunk",
)
