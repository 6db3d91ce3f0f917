"""Quintic polynomials meet the states at both ends."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wbc.geometry.quintic import evaluate_quintic, quintic_coefficients, step_quintic

numbers = st.floats(-2.0, 2.0)


@given(*[numbers] * 6)
def test_a_quintic_meets_both_states(x0, v0, a0, x1, v1, a1) -> None:
    c = quintic_coefficients(x0, v0, a0, x1, v1, a1)
    assert evaluate_quintic(c, 0.0) == pytest.approx((x0, v0, a0))
    assert evaluate_quintic(c, 1.0) == pytest.approx((x1, v1, a1), abs=1e-9)


@given(*[numbers] * 5, st.floats(0.1, 2.0), st.floats(0.01, 0.99))
def test_a_step_lies_on_the_quintic_to_the_target(x, v, a, target, end, T, s) -> None:
    c = quintic_coefficients(x, v * T, a * T * T, target, end * T)
    position, velocity, acceleration = evaluate_quintic(c, s)
    stepped = step_quintic(x, v, a, target, end, T, s * T)
    assert stepped[0] == pytest.approx(position, abs=1e-9)
    assert stepped[1] == pytest.approx(velocity / T, abs=1e-7)
    assert stepped[2] == pytest.approx(acceleration / T**2, abs=1e-5)


def test_a_step_beyond_the_remaining_time_arrives_exactly() -> None:
    assert step_quintic(0.3, 1.0, 2.0, 0.7, -0.1, 0.001, 0.002) == (0.7, -0.1, 0.0)
