"""Compiled parts of limits.

Without Numba the same source runs as plain Python.
"""

from wbc.jit.loading import load_kernels

# Here, so that a first import that compiles says so.
load_kernels("wbc.limits.kernels.distance")
