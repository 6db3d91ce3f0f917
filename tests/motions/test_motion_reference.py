"""References of motions: what is asked may jump, what they are does not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from coretools import many
from hypothesis import given
from hypothesis import strategies as st

from wbc.errors import MotionError
from wbc.motions import SmoothReference
from wbc.motions.keyframing.spline import Spline

DT = 0.002
JERK = 250.0  # per s³: what the orders below may ask, from rest or in mid-motion


def reference(n: int = 2) -> SmoothReference:
    return SmoothReference(np.zeros(n), speed=1.0, acceleration=4.0)


def circle(time: float) -> np.ndarray:
    return 0.1 * np.array([math.sin(3.0 * time), math.cos(3.0 * time)])


orders = st.lists(
    st.tuples(
        st.sampled_from(["go", "follow"]),
        st.floats(-0.5, 0.5),
        st.floats(0.8, 1.5),
        st.integers(1, 400),
    ),
    min_size=1,
    max_size=6,
)


@pytest.mark.slow
@many
@given(orders)
def test_reference_and_its_derivatives_stay_continuous_under_random_targets(script):
    x = reference()
    for kind, place, duration, ticks in script:
        if kind == "go":
            x.move_to(np.array([place, -place]), duration)
        else:
            x.follow(circle, blend=duration)
        for _ in range(ticks):
            value, velocity, acceleration = x.value, x.velocity, x.acceleration
            x.advance(DT)
            # What moved is what the velocity said, and so for the velocity.
            moved = DT * velocity + 0.5 * DT**2 * acceleration
            assert x.value == pytest.approx(value + moved, abs=JERK * DT**3)
            assert x.velocity == pytest.approx(velocity + DT * acceleration, abs=JERK * DT**2)
            assert np.abs(x.acceleration - acceleration).max() < JERK * DT


def test_move_from_rest_keeps_its_limits_and_ends_at_rest_at_the_target():
    x = reference()
    time = x.move_to(np.array([0.8, -0.2]), 0.1)
    assert time > 0.1  # the limits ask for more
    speed = acceleration = 0.0
    for _ in range(math.ceil(time / DT) + 1):
        x.advance(DT)
        speed = max(speed, float(np.abs(x.velocity).max()))
        acceleration = max(acceleration, float(np.abs(x.acceleration).max()))
    assert x.arrived
    assert x.value == pytest.approx([0.8, -0.2])
    assert not x.velocity.any()
    assert 0.8 < max(speed / 1.0, acceleration / 4.0) < 1.02


def test_path_is_followed_exactly_after_the_blend():
    x = reference()
    x.follow(circle, blend=0.5)
    for k in range(1, 500):
        x.advance(DT)
        if k * DT > 0.5:
            assert x.value == pytest.approx(circle(k * DT), abs=1e-12)
            assert x.velocity == pytest.approx(
                0.3 * np.array([math.cos(3 * k * DT), -math.sin(3 * k * DT)]), abs=1e-4
            )
    assert not x.arrived


def test_path_with_a_corner_keeps_the_acceleration_bounded():
    x = reference(1)
    x.follow(lambda t: np.array([0.2 * abs(t - 0.7)]), blend=0.2)
    for _ in range(600):
        x.advance(DT)
        assert abs(x.acceleration[0]) < 25.0


def test_invalid_targets_and_paths_are_refused():
    x = reference()
    with pytest.raises(MotionError, match=r"2 numbers was given \(3,\)"):
        x.move_to(np.zeros(3))
    with pytest.raises(MotionError, match="finite"):
        x.move_to(np.array([0.0, np.nan]))
    with pytest.raises(MotionError, match=r"\(1,\)"):
        x.follow(lambda t: np.zeros(1))


def test_spline_goes_through_its_points_smoothly_and_rests_at_both_ends():
    times = np.array([0.0, 1.0, 1.5, 3.0])
    points = np.array([[0.0], [1.0], [0.5], [0.7]])
    spline = Spline(times, points)
    for time, point in zip(times, points, strict=True):
        assert spline(time) == pytest.approx(point)
    for time in (1.0, 1.5):
        before, after = spline.derivatives(time - 1e-9), spline.derivatives(time + 1e-9)
        for a, b in zip(before, after, strict=True):
            assert a == pytest.approx(b, abs=1e-6)
    h = 1e-6
    x, v, a = spline.derivatives(2.0)
    assert v == pytest.approx((spline(2.0 + h) - spline(2.0 - h)) / (2 * h), abs=1e-6)
    assert a == pytest.approx(
        (spline.derivatives(2.0 + h)[1] - spline.derivatives(2.0 - h)[1]) / (2 * h), abs=1e-5
    )
    assert x == pytest.approx(spline(2.0))
    assert spline.derivatives(1e-9)[1] == pytest.approx([0.0], abs=1e-6)
    assert spline.derivatives(3.0 - 1e-9)[1] == pytest.approx([0.0], abs=1e-6)
    assert spline(9.0) == pytest.approx([0.7])
