"""Motions chosen by a line of text, as a ROS 2 system asks for them."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wbc.errors import MotionError
from wbc.motions import MOTIONS, Keyframes, OneLeg, Reach, Sine, Squat
from wbc.motions.engine import parse_motion


@pytest.mark.parametrize(
    ("text", "motion"),
    [
        ("squat", Squat()),
        ("  squat depth=15   times=2", Squat(depth=15.0, times=2)),
        ("one-leg leg=left hold=0.5", OneLeg(leg="left", hold=0.5)),
        ("reach left=0.3,0.2,1 random=2", Reach(left=(0.3, 0.2, 1.0), random=2)),
        ("sine open_loop=true", Sine(open_loop=True)),
        ("keyframes 'file=my wave.csv'", Keyframes(file="my wave.csv")),
    ],
)
def test_text_is_parsed_into_the_motion_it_describes(text, motion):
    assert parse_motion(text, MOTIONS) == motion


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no motion ''"),
        ("squad", "did you mean 'squat'"),
        ("squat 15", "'15' is not of the form parameter=value"),
        ("squat deep=15", "did you mean 'depth'"),
        ("squat depth=", "squat: depth is ''; it must be a number"),
        ("squat depth=nan", "out of range"),
        ("squat depth=1e9", "out of range"),
        ("squat depth=1e-9", "too small"),
        ("squat times=1.5", "integer"),
        ("squat depth=5 depth=6", "depth is given twice"),
        ("one-leg leg=middle", "left or right or both"),
        ("reach left=0.3,0.2", "3 numbers"),
        ("reach left=here", "3 numbers"),
        ("sine open_loop=yes", "true or false"),
        ("keyframes 'file=a", "cannot be read"),
    ],
)
def test_text_that_describes_no_motion_is_refused_with_the_reason(text, why):
    with pytest.raises(MotionError, match=why):
        parse_motion(text, MOTIONS)


@given(st.text(max_size=40) | st.text(max_size=30).map(lambda rest: f"squat {rest}"))
def test_any_text_is_parsed_or_refused_with_a_motion_error(text):
    with contextlib.suppress(MotionError):
        assert type(parse_motion(text, MOTIONS)) in MOTIONS
