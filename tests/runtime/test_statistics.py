"""Figures of a run: path length and speed over the ground."""

from __future__ import annotations

import numpy as np
import pytest

import wbc
from wbc.sim import Mujoco


def test_standing_robot_travels_no_distance() -> None:
    robot = wbc.load("talos")
    with Mujoco(robot, seed=0) as plant:
        report = wbc.run(wbc.Walker(robot), plant, 8.0)
    assert report.survived
    assert report.distance_m < 0.02
    assert report.mean_speed_m_s == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["talos", "g1"])
def test_robot_that_stands_for_a_minute_keeps_both_feet_where_they_were(name: str) -> None:
    robot = wbc.load(name)
    with Mujoco(robot, seed=1) as plant:
        start = plant.ground_truth()
        report = wbc.run(wbc.Walker(robot), plant, 60.0)
        end = plant.ground_truth()
    assert report.survived
    assert report.distance_m < 0.02
    before, after = (wbc.Kinematics(robot, state) for state in (start, end))
    for sole in robot.soles:
        moved = after.frame(sole.name).translation - before.frame(sole.name).translation
        assert np.linalg.norm(moved[:2]) < 1e-3
