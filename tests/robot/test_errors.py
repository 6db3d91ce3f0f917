"""The library's exceptions: they suggest names, and they survive being sent to another process."""

from __future__ import annotations

import pickle

import pytest

from wbc import errors

NAMES = ["left_knee", "right_knee", "left_elbow"]
ALL = [
    errors.FrameNotFound("left_kne", NAMES, "Robot.frame_id"),
    errors.JointNotFound("elbow", NAMES),
    errors.MissingExtra("mujoco", "sim"),
    errors.RobotDescriptionError("robot.urdf: no link; add one"),
    errors.StateError("state.q has shape (3,)"),
]


@pytest.mark.parametrize("error", ALL, ids=lambda error: type(error).__name__)
def test_an_error_is_the_same_in_another_process(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert isinstance(again, errors.WbcError)


def test_unknown_names_are_refused_with_similar_ones():
    assert "did you mean 'left_knee'" in str(ALL[0])
    assert str(ALL[0]).startswith("Robot.frame_id: the model has no frame 'left_kne'")
    assert "'left_elbow'" in str(ALL[1])
    assert "; there are: left_knee" in str(errors.JointNotFound("xyz", NAMES))


def test_long_values_are_abbreviated_in_messages():
    assert errors.short_repr(0.3) == "0.3"
    assert errors.short_repr(None) == "missing"
    assert len(errors.short_repr("a" * 200)) == 58
    assert errors.short_repr(10**5000) == "a number of very many digits"
