"""Quintic polynomials meet the states at both ends."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients

numbers = st.floats(-2.0, 2.0)


@given(*[numbers] * 6)
def test_a_quintic_meets_both_states(x0, v0, a0, x1, v1, a1) -> None:
    c = quintic_coefficients(x0, v0, a0, x1, v1, a1)
    assert evaluate_quintic(c, 0.0) == pytest.approx((x0, v0, a0))
    assert evaluate_quintic(c, 1.0) == pytest.approx((x1, v1, a1), abs=1e-9)
