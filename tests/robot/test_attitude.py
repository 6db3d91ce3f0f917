"""Attitude and falls, whatever way a model's base link points."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.robot.attitude import attitude, heading
from wbc.robot.fall import fall_reason

ROBOTS = [wbc.load(name) for name in ("talos", "icub")]  # iCub's base points backward
angles = st.floats(-3.0, 3.0)


def turned(robot: wbc.Robot, rotation: np.ndarray) -> wbc.State:
    state = robot.standing()
    base = pin.XYZQUATToSE3(state.q[:7])
    state.q[3:7] = pin.Quaternion(rotation @ base.rotation).coeffs()
    return state


@given(st.sampled_from(ROBOTS), st.lists(angles, min_size=3, max_size=3))
def test_attitude_is_the_rotation_relative_to_standing(robot: wbc.Robot, rpy: list[float]) -> None:
    rotation = pin.rpy.rpyToMatrix(*rpy)
    found = pin.Quaternion(np.array(attitude(robot, turned(robot, rotation)))).matrix()
    assert found == pytest.approx(rotation, abs=1e-9)


@given(st.sampled_from(ROBOTS), angles)
def test_heading_is_zero_in_the_standing_posture(robot: wbc.Robot, yaw: float) -> None:
    state = turned(robot, pin.utils.rotate("z", yaw))
    assert heading(robot, state) == pytest.approx(yaw, abs=1e-9)
    assert fall_reason(robot, state) == ""


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: r.name)
def test_fall_is_detected_by_tilt_and_by_height(robot: wbc.Robot) -> None:
    assert fall_reason(robot, turned(robot, pin.utils.rotate("x", np.radians(65.0)))) == ""
    assert "tilted by 75°" in fall_reason(
        robot, turned(robot, pin.utils.rotate("x", np.radians(75.0)))
    )
    assert "tilted by 90°" in fall_reason(robot, turned(robot, pin.utils.rotate("y", -np.pi / 2)))
    low = robot.standing()
    low.q[2] *= 0.5
    assert "above the ground" in fall_reason(robot, low)
    assert fall_reason(robot, low, ground=-1.0) == ""
