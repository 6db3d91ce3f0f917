"""Readings of sensors, as somebody else's code hands them over."""

from __future__ import annotations

from typing import TypeGuard

import numpy as np

_NUMBERS = "fiu"  # kinds of data types: floating-point, signed and unsigned numbers


def is_array_of_numbers(x: object) -> TypeGuard[np.ndarray]:
    """Return whether a reading is an array of real numbers, of whatever type and shape."""
    return isinstance(x, np.ndarray) and x.dtype.kind in _NUMBERS


def is_vector_of_numbers(x: object) -> TypeGuard[np.ndarray]:
    """Return whether a reading is an array of real numbers with one dimension."""
    return is_array_of_numbers(x) and x.ndim == 1
