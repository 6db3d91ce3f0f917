"""Just-in-time compilation: kernels that Numba compiles, caches and loads.

Importing this room does not import Numba; `wbc.jit.compile`, which kernels import, does.
"""
