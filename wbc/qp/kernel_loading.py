"""The compiled kernels of the controller."""

from __future__ import annotations

from wbc.jit.loading import load_kernels


def load_qp_kernels() -> bool:
    """Import the compiled assembly and solver; False, with a warning, when that is impossible."""
    return load_kernels("wbc.qp.compiled", "wbc.qp.kernels.dual_active_set")
