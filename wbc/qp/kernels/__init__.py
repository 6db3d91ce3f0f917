"""The compiled parts of a tick; importing them needs Numba."""
