"""Just-in-time compilation by Numba: how kernels are compiled, cached and loaded.

Importing this room does not import Numba; `wbc.jit.compile`, which kernels import, does.
"""
