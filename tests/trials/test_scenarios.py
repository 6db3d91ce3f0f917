"""Scenarios, and a seeded run with its verdict."""

from __future__ import annotations

import math

import pytest

import wbc
from wbc.errors import GaitError
from wbc.trials import circle, forward, run_scenario, sideways, turn


def test_a_scenario_stands_walks_and_stands():
    scenario = forward(2.0, 0.4, stand_time=3.0)
    assert scenario.velocity_at(0.5) == (0.0, 0.0, 0.0)
    assert scenario.velocity_at(2.0) == (0.4, 0.0, 0.0)
    assert scenario.velocity_at(scenario.duration - 2.9) == (0.0, 0.0, 0.0)
    assert scenario.duration == pytest.approx(1.0 + 2.0 / 0.4 + 1.5 + 3.0)


def test_walking_backwards_counts_distance_backwards():
    assert forward(2.0, -0.2).velocity_at(2.0) == (-0.2, 0.0, 0.0)
    assert forward(2.0, -0.2).duration == forward(2.0, 0.2).duration


def test_a_circle_turns_by_its_curvature():
    velocity = circle(1.0, 0.25).velocity_at(2.0)
    assert velocity[2] == pytest.approx(0.25 / 1.0)


@pytest.mark.parametrize("make", [forward, sideways, turn, circle])
@pytest.mark.parametrize("speed", [0.0, math.nan, math.inf])
def test_a_scenario_of_zero_or_infinite_speed_is_refused(make, speed):
    with pytest.raises(GaitError, match="finite and not zero"):
        make(1.0, speed)


def test_a_run_passes_only_if_it_reaches_its_goal():
    pytest.importorskip("mujoco")
    robot = wbc.load("simple_humanoid")
    scenario = forward(0.3, 0.3, stand_time=1.0)
    report = run_scenario(robot, scenario, seed=1)
    assert scenario.metric(report) > 0.25
    assert scenario.passed(report) == (scenario.metric(report) >= 0.3)
    assert not forward(0.3, 0.3, min_cruise_speed=9.0).passed(report)
