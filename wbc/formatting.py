"""Numbers as a person reads them, for `repr` and messages."""

from __future__ import annotations

import numpy as np


def format_range(values: np.ndarray, unit: str = "") -> str:
    """Return "2 to 30 rad/s", or one number when all values are the same."""
    low, high = float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))
    text = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f"{text} {unit}".rstrip()


def format_vector(values: np.ndarray, unit: str = "") -> str:
    """Return "(0.1, 0, 0.87) m"."""
    text = ", ".join(f"{value:.3g}" for value in np.asarray(values, dtype=float) + 0.0)
    return f"({text}) {unit}".rstrip()
