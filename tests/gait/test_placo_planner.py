"""The planner with placo's walk pattern: its program, and its process."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import wbc
from wbc.gait import PlanFailed
from wbc.gait.planners.placo_program import ComRequest, plan_com
from wbc.geometry.planar import Placement
from wbc.geometry.polygon import convex_hull, sole_corners

OMEGA, INTERVAL = 3.5, 0.04


def request(start: complex = 0j, velocity: complex = 0j, stride: float = 0.1) -> ComRequest:
    """Two steps from between the feet, and rest beside the last one."""
    feet = [Placement(-0.08j, 0.0), Placement(stride + 0.08j, 0.0)]
    soles = [sole_corners(foot, 0.1, 0.05) for foot in feet]
    both = tuple(convex_hull([*soles[0], *soles[1]]))
    middle = 0.5 * (feet[0].point + feet[1].point)
    phases = [(0j, both, 5), (feet[0].point, tuple(soles[0]), 14), (middle, both, 20)]
    zmp = [point for point, _, count in phases for _ in range(count)]
    polygons = [polygon for _, polygon, count in phases for _ in range(count)]
    return ComRequest(OMEGA, INTERVAL, start, velocity, 0j, tuple(zmp), tuple(polygons))


def is_inside(point: complex, polygon: tuple[complex, ...]) -> bool:
    edges = zip(polygon, polygon[1:] + polygon[:1], strict=True)
    return all(((b - a).conjugate() * (point - a)).imag >= -1e-6 for a, b in edges)


@settings(max_examples=8, deadline=None)
@given(st.floats(-0.02, 0.02), st.floats(-0.05, 0.05), st.floats(0.0, 0.2))
def test_plan_starts_at_the_state_keeps_the_zmp_on_the_feet_and_ends_at_rest(x, vy, stride):
    wanted = request(complex(x, 0.0), complex(0.0, vy), stride)
    plan = plan_com(wanted)
    assert plan is not None
    assert plan.at(0.0) == pytest.approx((complex(x, 0.0), complex(0.0, vy), 0j), abs=1e-12)
    for node, polygon in enumerate(wanted.polygons[:-1], 1):
        com, _, acceleration = plan.at(node * INTERVAL)
        assert is_inside(com - acceleration / OMEGA**2, polygon)
    com, velocity, acceleration = plan.at(plan.duration)
    assert com == pytest.approx(wanted.zmp[-1], abs=2e-3)
    assert abs(velocity) < 0.01
    assert abs(acceleration) < 0.1


def test_plan_is_smooth_between_its_nodes():
    plan = plan_com(request())
    times = np.arange(0.0, plan.duration - INTERVAL, 1e-3)
    com, velocity, acceleration = np.array([plan.at(t) for t in times]).T
    np.testing.assert_allclose(np.diff(com), 1e-3 * velocity[:-1], atol=5e-6)
    assert abs(np.diff(velocity) - 1e-3 * acceleration[:-1]).max() < 1e-4


def test_a_state_that_no_zmp_on_the_feet_catches_has_no_plan():
    assert plan_com(request(0.5 + 0j, 3.0 + 0j)) is None


def test_the_analytic_plan_goes_on_when_the_process_dies():
    robot = wbc.load("simple_humanoid")
    walker = wbc.Walker(robot, planner="placo")
    walker.reset(robot.standing())
    walker.velocity = (0.2, 0.0, 0.0)
    estimate = wbc.Estimate(robot.standing())
    commands = [walker.step(estimate) for _ in range(5)]
    walker.planner._process.close()
    with pytest.warns(PlanFailed, match="has died"):
        commands += [walker.step(estimate) for _ in range(30)]
    command = commands[-1]
    assert command.status is wbc.Status.OK
    assert walker.planner.failures == 1
